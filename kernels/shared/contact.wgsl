// Colliders, and the contacts of skin vertices with them (method §7).

struct Collider {
    rotation: mat3x3<f32>,
    position: vec3<f32>,    // relative to the instance's origin
    stiffness: f32,         // k, Pa/m
    parameters: vec4<f32>,  // sizes of the shape
    margin: f32,            // d̂, m
    shape: u32,
}

// An active contact. Side A is the vertex with its bones and handles, side B the collider's frame,
// which is kinematic: it has no degrees of freedom.
struct Contact {
    normal: vec3<f32>,      // n, out of the collider
    depth: f32,             // δ = d̂ − d > 0
    stiffness: f32,         // k a, N/m
    vertex: u32,
    collider: u32,
}

// A state's list of contacts begins with an item that only counts: its `vertex` is how many were
// found, also where there was no room for them.
fn contact_header(lane: u32) -> u32 {
    return lane * (constants.contacts + 1u);
}

// Distances are kept as (n, δ), vertex after vertex, the colliders of one vertex in a row.
fn first_distance(slot: u32, vertex: u32, colliders: u32) -> u32 {
    return slot * constants.points * constants.colliders + vertex * colliders;
}
