// Colliders, and the contacts of skin vertices with them (method §7).

struct Collider {
    rotation: mat3x3<f32>,
    position: vec3<f32>,         // relative to the instance's origin, or in the body's frame
    stiffness: f32,              // k, Pa/m; 0 where it is the tissue's
    parameters: vec4<f32>,       // sizes of the shape
    margin: f32,                 // d̂, m
    shape: u32,
    friction: f32,               // μ
    body: u32,                // 1 + the frame that carries it, 0 where its motion is given
    rotation_change: mat3x3<f32>,  // over the step, where its motion is given
    position_change: vec3<f32>,
}

// One direction in which a contact acts: E changes by f (e · δz) + ½ k (e · δz)², z the vertex's place
// seen from the collider. A push is one row (e = n, f = −k a δ, k = k a), friction is two. Side A is the
// vertex with its bones and handles, side B the frame that carries the collider.
struct Contact {
    direction: vec3<f32>,   // e
    force: f32,             // f, N
    stiffness: f32,         // k, N/m
    vertex: u32,
    body: u32,           // as a collider's
}

// Room for rows in a state's list: the push of each contact, and friction's two.
fn row_room() -> u32 {
    return 3u * constants.contacts;
}

// A state's list of rows begins with an item that only counts: its `vertex` is how many contacts were
// found, also where there was no room for them, its `body` how many rows there are.
fn contact_header(thread: u32) -> u32 {
    return thread * (row_room() + 1u);
}

// In place of the δ of a pair that is left out: no distance is so small. Where the pair touches it is twice that.
const LEFT_OUT = -1e38;

fn left_out(depth: f32) -> f32 {
    return select(LEFT_OUT, 2.0 * LEFT_OUT, depth > 0.0);
}

fn is_left_out(depth: f32) -> bool {
    return depth < 0.5 * LEFT_OUT;
}

fn touches_but_is_left_out(depth: f32) -> bool {
    return depth < 1.5 * LEFT_OUT;
}

// Distances are kept as (n, δ), vertex after vertex, the colliders of one vertex in a row.
fn first_distance(slot: u32, vertex: u32, colliders: u32) -> u32 {
    return slot * constants.points * constants.colliders + vertex * colliders;
}
