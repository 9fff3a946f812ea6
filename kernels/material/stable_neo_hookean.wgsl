// The ground substance alone (shared/neo_hookean.wgsl): isotropic, so that no axes matter.

struct StableNeoHookeanParameters {
    mu: f32,      // Lamé's, Pa
    lambda: f32,
}

alias MaterialParameters = StableNeoHookeanParameters;

fn pk1_stress(h: mat3x3<f32>, axes: mat3x3<f32>) -> mat3x3<f32> {
    return neo_hookean_stress(h);
}

fn energy_difference(h: mat3x3<f32>, d: mat3x3<f32>, axes: mat3x3<f32>) -> f32 {
    return neo_hookean_energy_difference(h, d);
}

// C less its negative eigenvalues. In the frame of F = U diag(σ) Vᵀ (Smith et al. 2018, §4.5) the twists
// U (e_i e_jᵀ − e_j e_iᵀ) Vᵀ/√2 have μ + p σ_k, the flips (with +) μ − p σ_k, and the scalings
// U diag(a) Vᵀ are the eigenvectors a of μ I + (λ + μ) s sᵀ + p offdiag(σ), s_i = σ_j σ_k.
fn projected_tangent(h: mat3x3<f32>, axes: mat3x3<f32>) -> Tangent {
    let mu = material.mu;
    let kappa = material.lambda + mu;
    let p = neo_hookean_pressure(h);
    var c = neo_hookean_tangent(h);
    let svd = singular_values(h);
    for (var k = 0u; k < 3u; k++) {
        let i = (k + 1u) % 3u;
        let j = (k + 2u) % 3u;
        let ij = outer(svd.u[i], svd.v[j]);
        let ji = outer(svd.u[j], svd.v[i]);
        // Modes of length √2, hence halves.
        let twist = 0.5 * min(mu + p * svd.sigma[k], 0.0);
        let flip = 0.5 * min(mu - p * svd.sigma[k], 0.0);
        if (twist < 0.0) {
            c = add_mode(c, -twist, ij - ji);
        }
        if (flip < 0.0) {
            c = add_mode(c, -flip, ij + ji);
        }
    }
    let s = svd.sigma;
    let area = vec3(s.y * s.z, s.z * s.x, s.x * s.y);
    let scaling = symmetric_eigen(mu * identity() + kappa * outer(area, area)
        + p * mat3x3<f32>(0.0, s.z, s.y, s.z, 0.0, s.x, s.y, s.x, 0.0));
    for (var k = 0u; k < 3u; k++) {
        if (scaling.values[k] < 0.0) {
            let b = scaling.vectors[k];
            let mode = mat3x3<f32>(b.x * svd.u[0], b.y * svd.u[1], b.z * svd.u[2]) * transpose(svd.v);
            c = add_mode(c, -scaling.values[k], mode);
        }
    }
    return c;
}
