// The ground substance alone (shared/neo_hookean.wgsl): isotropic, so that no axes matter.

struct StableNeoHookeanParameters {
    mu: f32,      // Lamé's, Pa
    lambda: f32,
}

alias MaterialParameters = StableNeoHookeanParameters;

fn pk1_stress(h: mat3x3<f32>, axes: mat3x3<f32>) -> mat3x3<f32> {
    return neo_hookean_stress(h, material.mu, material.lambda);
}

fn energy_difference(h: mat3x3<f32>, d: mat3x3<f32>, axes: mat3x3<f32>) -> f32 {
    return neo_hookean_energy_difference(h, d, material.mu, material.lambda);
}

// C less its negative eigenvalues.
fn projected_tangent(h: mat3x3<f32>, axes: mat3x3<f32>) -> Tangent {
    return projected_neo_hookean_tangent(h, material.mu, material.lambda, 0.0);
}
