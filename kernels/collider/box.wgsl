// With q = |x| − b: d = |max(q, 0)| outside and max q inside; n is that of the nearest face, or away
// from the nearest edge or corner. parameters = (b, ·)
fn box_distance(parameters: vec4<f32>, p: vec3<f32>) -> SignedDistance {
    let q = abs(p) - parameters.xyz;
    let side = select(vec3(1.0), vec3(-1.0), p < vec3(0.0));
    let largest = max(q.x, max(q.y, q.z));
    if (largest > 0.0) {
        let out = length_and_direction(max(q, vec3(0.0)), vec3(1.0, 0.0, 0.0));
        return SignedDistance(out.normal * side, out.distance);
    }
    let face = select(select(vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), q.y >= q.z),
        vec3(1.0, 0.0, 0.0), q.x >= max(q.y, q.z));
    return SignedDistance(face * side, largest);
}
