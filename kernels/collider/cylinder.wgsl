// With ρ = √(x² + y²) and q = (ρ − r, |z| − l): d = |max(q, 0)| outside and max(q_ρ, q_z) inside;
// n is that of the nearest face, or away from the rim. parameters = (r, l, ·, ·)
fn cylinder_distance(parameters: vec4<f32>, p: vec3<f32>) -> SignedDistance {
    let radial = length_and_direction(vec3(p.xy, 0.0), vec3(1.0, 0.0, 0.0));
    let axial = vec3(0.0, 0.0, select(1.0, -1.0, p.z < 0.0));
    let q = vec2(radial.distance - parameters.x, abs(p.z) - parameters.y);
    if (q.x > 0.0 && q.y > 0.0) {
        let d = length(q);
        return SignedDistance((q.x * radial.normal + q.y * axial) / d, d);
    }
    if (q.x > q.y) {
        return SignedDistance(radial.normal, q.x);
    }
    return SignedDistance(axial, q.y);
}
