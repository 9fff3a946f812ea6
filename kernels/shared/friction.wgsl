// Lagged, smoothed Coulomb friction (Li et al. 2020, Incremental Potential Contact, §4):
//   E = Σ μ λ f₀(|u_T|)      f₀(y) = y²/ε − y³/(3 ε²) below ε = ε_v h, y − ε/3 above

// A contact of qⁿ with a rough collider.
struct Lagged {
    anchor: vec3<f32>,  // a: where the vertex was in the frame that the collider is fixed to
    limit: f32,         // μ λ, N
    normal: vec3<f32>,  // n in the body's axes; in the world's where the collider's motion is given
    vertex: u32,
    start: vec3<f32>,   // u at qⁿ: −(ΔR a + Δc) of a collider whose motion is given
    body: u32,       // as a collider's
    collider: u32,
}

// An instance's list begins with an item that only counts: its `vertex` is how many were found, also
// where there was no room for them.
fn lagged_header(instance: u32) -> u32 {
    return instance * (constants.contacts + 1u);
}

// u − n (n · u)
fn tangential(u: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    return u - dot(n, u) * n;
}

// (f₀′/y, f₀″)
fn smoothed_slopes(y: f32, smoothing: f32) -> vec2<f32> {
    if (y >= smoothing) {
        return vec2(1.0 / y, 0.0);
    }
    let rest = 1.0 - y / smoothing;
    return vec2((1.0 + rest) / smoothing, 2.0 * rest / smoothing);
}

// f₀(y) − f₀(base)
fn smoothed_difference(base: f32, y: f32, smoothing: f32) -> f32 {
    let b = min(base, smoothing);
    let s = min(y, smoothing);
    let mean_slope =
        (s + b) / smoothing - (s * s + s * b + b * b) / (3.0 * smoothing * smoothing);
    return (s - b) * mean_slope + (y - s) - (base - b);
}
