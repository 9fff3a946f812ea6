// What a collider's shape answers at a point of its own frame.

struct SignedDistance {
    normal: vec3<f32>,  // ∇d, outward
    distance: f32,      // d, negative inside
}

// (|v|, v/|v|) as a distance, along `fallback` where v is zero
fn length_and_direction(v: vec3<f32>, fallback: vec3<f32>) -> SignedDistance {
    let length = length(v);
    return SignedDistance(select(fallback, v / length, length > 1e-18), length);
}
