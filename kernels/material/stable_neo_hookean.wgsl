// Ψ = μ/2 (I_C − 3) − μ (J − 1) + (λ + μ)/2 (J − 1)²  (Smith et al. 2018, reparametrised so that ν
// holds). F = I + H, and everything is written in H, because near rest F − cof F and J − 1 cancel.
// constants.material = (μ, λ, ·, ·).

// J − 1 = tr H + tr cof H + det H
fn volume_change(h: mat3x3<f32>) -> f32 {
    return trace(h) + trace(cofactor(h)) + det(h);
}

// F − cof F = H + Hᵀ − tr H I − cof H
fn shear_stress(h: mat3x3<f32>) -> mat3x3<f32> {
    return h + transpose(h) - trace(h) * identity() - cofactor(h);
}

// P = μ (F − cof F) + (λ + μ)(J − 1) cof F
fn pk1_stress(h: mat3x3<f32>) -> mat3x3<f32> {
    let mu = constants.material.x;
    let lambda = constants.material.y;
    return mu * shear_stress(h)
        + ((lambda + mu) * volume_change(h)) * cofactor(identity() + h);
}

// Ψ(F + D) − Ψ(F) with s = F : cof D + det D and ΔJ = cof F : D + s:
// μ ((F − cof F) : D + ½ D : D − s) + (λ + μ)/2 ΔJ (2 (J − 1) + ΔJ)
fn energy_difference(h: mat3x3<f32>, d: mat3x3<f32>) -> f32 {
    let mu = constants.material.x;
    let lambda = constants.material.y;
    let f = identity() + h;
    let s = double_dot(f, cofactor(d)) + det(d);
    let dj = double_dot(cofactor(f), d) + s;
    let shear = double_dot(shear_stress(h), d) + 0.5 * double_dot(d, d) - s;
    return mu * shear + 0.5 * (lambda + mu) * dj * (2.0 * volume_change(h) + dj);
}

// C = ∂P/∂F = μ I₉ + (λ + μ) cof F ⊗ cof F + p ∂cof F/∂F, p = (λ + μ)(J − 1) − μ, less its negative
// eigenvalues. In the frame of F = U diag(σ) Vᵀ (Smith et al. 2018, §4.5) the twists
// U (e_i e_jᵀ − e_j e_iᵀ) Vᵀ/√2 have μ + p σ_k, the flips (with +) μ − p σ_k, and the scalings
// U diag(a) Vᵀ are the eigenvectors a of μ I + (λ + μ) s sᵀ + p offdiag(σ), s_i = σ_j σ_k.
fn projected_tangent(h: mat3x3<f32>) -> Tangent {
    let mu = constants.material.x;
    let kappa = constants.material.y + mu;
    let f = identity() + h;
    let p = kappa * volume_change(h) - mu;
    let a = cofactor(f);
    // Column k of cof F is F_i × F_j, (i, j, k) cyclic.
    var c = Tangent(
        mu * identity() + kappa * outer(a[0], a[0]),
        kappa * outer(a[1], a[0]) + p * skew(f[2]),
        mu * identity() + kappa * outer(a[1], a[1]),
        kappa * outer(a[2], a[0]) - p * skew(f[1]),
        kappa * outer(a[2], a[1]) + p * skew(f[0]),
        mu * identity() + kappa * outer(a[2], a[2]),
    );
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
