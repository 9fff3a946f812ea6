// ∂E/∂q, first point by point, then gathered block by block in fixed order. With the force
//   f = m ( (d − ŷ)/h̃² − g ),  m = ρ w,  ŷ the displacement in the step's start (kernels/inertial_target.wgsl),
// and a = R_j (T − J_j):  c_j: w_j f     ω_j: w_j a × f     φ_h: U_h Bᵀ f + w P ∇U_h, B = Σ w_j R_j

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read> handle_gradients: array<HandleGradient>;
@group(0) @binding(6) var<storage, read> frames: array<Frame>;
@group(0) @binding(7) var<storage, read> motion: array<Motion>;
@group(0) @binding(8) var<storage, read> stress: array<mat3x3<f32>>;
@group(0) @binding(9) var<storage, read_write> point_gradients: array<vec3<f32>>;

// One thread a cubature point.
@compute @workgroup_size(64)
fn point_gradient(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= constants.points) {
        return;
    }
    let state = batch[chunk.first + id.y];
    let point = points[i];
    let moved = motion[state.slot * constants.points + i];
    let target_displacement = motion[state.instance * constants.points + i].displacement;
    let mass = constants.density * point.measure;
    let force = mass
        * (state.mass_rate * (moved.displacement - target_displacement) - state.gravity);
    let weighted_stress = point.measure * stress[state.slot * constants.points + i];

    let first = id.y * constants.local_blocks + point.first_block;
    let unposed_force = force * moved.blended;
    for (var k = 0u; k < point.bones; k++) {
        let w = influences[point.first_influence + k];
        let f = state.slot * constants.bones + w.index;
        point_gradients[first + 2u * k] = w.weight * force;
        point_gradients[first + 2u * k + 1u] =
            w.weight * cross(frames[f].rotation * (moved.unposed - frames[f].joint), force);
    }
    for (var k = 0u; k < point.handles; k++) {
        let u = influences[point.first_influence + point.bones + k];
        let g = handle_gradients[point.first_gradient + k].gradient;
        point_gradients[first + 2u * point.bones + k] =
            u.weight * unposed_force + weighted_stress * g;
    }
}

@group(0) @binding(10) var<storage, read> gather_rows: array<u32>;
@group(0) @binding(11) var<storage, read> gather_entries: array<u32>;
@group(0) @binding(12) var<storage, read> contacts: array<Contact>;
@group(0) @binding(13) var<storage, read> contact_rows: array<vec3<f32>>;
@group(0) @binding(14) var<storage, read> block_contacts: array<u32>;
@group(0) @binding(15) var<storage, read_write> result: array<f32>;

var<workgroup> sums: array<vec3<f32>, 64>;

// Σ over the points of a block, and Σ f Jᵀe over its contacts' rows. One workgroup a block: thread l
// takes every 64th term, then the threads are summed in a fixed tree.
@compute @workgroup_size(64)
fn gradient(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let block = group.x;
    var sum = vec3<f32>();
    let first = group.y * constants.local_blocks;
    for (var k = gather_rows[block] + thread; k < gather_rows[block + 1u]; k += 64u) {
        sum += point_gradients[first + gather_entries[k]];
    }
    let list = (group.y * constants.blocks + block) * (row_room() + 1u);
    for (var k = thread; k < block_contacts[list]; k += 64u) {
        let entry = block_contacts[list + 1u + k];
        let contact = contacts[contact_header(group.y) + 1u + entry / 256u];
        let at = group.y * row_room() + entry / 256u;
        let row = contact_rows[at * constants.contact_blocks + entry % 256u];
        sum += contact.force * row;
    }
    sums[thread] = sum;
    workgroupBarrier();
    for (var width = 32u; width > 0u; width /= 2u) {
        if (thread < width) {
            sums[thread] += sums[thread + width];
        }
        workgroupBarrier();
    }
    if (thread == 0u) {
        let stride = 3u * constants.blocks + 9u * constants.pattern_blocks;
        let out = (chunk.first + group.y) * stride + 3u * block;
        result[out] = sums[0].x;
        result[out + 1u] = sums[0].y;
        result[out + 2u] = sums[0].z;
    }
}
