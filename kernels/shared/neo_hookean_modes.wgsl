// C + a A ⊗ A less its negative eigenvalues, A = F − cof F + (J − 1) cof F. In the frame of F = U diag(σ) Vᵀ (Smith et al.
// 2018, §4.5) the twists U (e_i e_jᵀ − e_j e_iᵀ) Vᵀ/√2 have μ + p σ_k, the flips (with +) μ − p σ_k, and the scalings
// U diag(v) Vᵀ are the eigenvectors v of μ I + (λ + μ) s sᵀ + p offdiag(σ) + a g gᵀ, s_i = σ_j σ_k, g = σ + (J − 2) s.
fn projected_neo_hookean_tangent(h: mat3x3<f32>, mu: f32, lambda: f32, growth: f32) -> Tangent {
    let kappa = lambda + mu;
    let p = neo_hookean_pressure(h, mu, lambda);
    let volume = volume_change(h);
    var c = neo_hookean_tangent(h, mu, lambda);
    if (growth > 0.0) {
        c = add_mode(c, growth, shear_stress(h) + volume * cofactor(identity() + h));
    }
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
    let gradient = s + (volume - 1.0) * area;
    let scaling = symmetric_eigen(mu * identity() + kappa * outer(area, area)
        + p * mat3x3<f32>(0.0, s.z, s.y, s.z, 0.0, s.x, s.y, s.x, 0.0)
        + growth * outer(gradient, gradient));
    for (var k = 0u; k < 3u; k++) {
        if (scaling.values[k] < 0.0) {
            let b = scaling.vectors[k];
            let mode = mat3x3<f32>(b.x * svd.u[0], b.y * svd.u[1], b.z * svd.u[2]) * transpose(svd.v);
            c = add_mode(c, -scaling.values[k], mode);
        }
    }
    return c;
}
