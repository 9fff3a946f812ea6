// d = z, n = e_z
fn half_space_distance(parameters: vec4<f32>, p: vec3<f32>) -> SignedDistance {
    return SignedDistance(vec3(0.0, 0.0, 1.0), p.z);
}
