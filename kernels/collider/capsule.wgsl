// d = |x − a| − r, n = (x − a)/|x − a| with a the nearest point of the axis; parameters = (r, l, ·, ·)
fn capsule_distance(parameters: vec4<f32>, p: vec3<f32>) -> SignedDistance {
    let nearest = clamp(p.z, -parameters.y, parameters.y);
    let ball = length_and_direction(vec3(p.xy, p.z - nearest), vec3(1.0, 0.0, 0.0));
    return SignedDistance(ball.normal, ball.distance - parameters.x);
}
