// How stiffly a skin vertex is pushed out of a collider.

// The stiffest penalty that nobody asked for, Pa/m.
const STIFFEST = 1e8;

// k a, N/m: the collider's own k, or else the tissue's under the vertex with the instance's factor.
fn contact_stiffness(collider: Collider, point: Point, state: BatchState) -> f32 {
    let tissue = min(point.contact_stiffness * state.stiffness, STIFFEST);
    return select(tissue, collider.stiffness, collider.stiffness > 0.0) * point.measure;
}
