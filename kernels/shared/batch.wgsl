// What a kernel knows of the avatar and of the states it is run on.
//
// A batch is a list of states. Every state reads and writes its own slot: slot i < instances is the
// start qⁿ of instance i, the others hold Newton's iterates and the trials of its line search.
// Workgroup row y of a dispatch is state chunk.first + y of the batch, and scratch buffers are
// indexed by y.

struct Constants {
    points: u32,          // of the set that the kernel runs over
    bones: u32,
    handles: u32,
    features: u32,
    blocks: u32,          // 3-vectors of q
    pattern_blocks: u32,  // stored blocks of the Hessian
    local_blocks: u32,    // Σ over cubature points of their own blocks
    local_pairs: u32,     // Σ over cubature points of their own pairs of blocks
    colliders: u32,       // room for colliders, an instance
    contacts: u32,        // room for active contacts, a state
    contact_blocks: u32,  // most blocks that move one skin vertex, and a body's two
    point_groups: u32,    // partial energies of the cubature points, then
    vertex_groups: u32,   // those of the skin
    density: f32,         // ρ, kg/m³
    skin_stride: u32,     // from an instance's posed skin to the next one's, vertices
    offset_vertices: u32, // skin vertices that may have offsets, an instance
}

struct Chunk {
    first: u32,
}

struct BatchState {
    gravity: vec3<f32>,   // on the tissue's displacement, m/s²
    mass_rate: f32,       // 1/h̃², 1/s²
    damping_rate: f32,    // what β is multiplied by, 1/h̃ with its factor; 0 where nothing damps
    instance: u32,
    slot: u32,
    base: u32,            // slot of the state that the energy is measured from
    colliders: u32,
    smoothing: f32,       // ε = ε_v h, m
    stiffness: f32,       // factor on the tissue's
    has_offsets: u32,     // whether the host gave offsets of the skin
    tension: f32,         // (T − 1) τ: times the share of muscle, what tension adds to 1
}

// A start is qⁿ itself, which has no increments of its own. Those of its frames are zero, its handles' are the drift φ̃ − φⁿ of
// damping, and its points' displacements are ŷ.
fn is_start(slot: u32, instance: u32) -> bool {
    return slot == instance;
}
