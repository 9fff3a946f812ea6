// d = |x| − r, n = x/|x|; parameters = (r, ·, ·, ·)
fn sphere_distance(parameters: vec4<f32>, p: vec3<f32>) -> SignedDistance {
    let ball = length_and_direction(p, vec3(0.0, 0.0, 1.0));
    return SignedDistance(ball.normal, ball.distance - parameters.x);
}
