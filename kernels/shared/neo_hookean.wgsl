// Ψ = μ/2 (I_C − 3) − μ (J − 1) + (λ + μ)/2 (J − 1)²  (Smith et al. 2018, reparametrised so that ν
// holds). F = I + H, and everything is written in H, because near rest F − cof F and J − 1 cancel.
// Sorted by parameters Ψ = μ/2 Q + λ/2 (J − 1)², Q = I_C − 4J + J², ½ ∂Q/∂F = A: what stiffens with Q has its μ from outside.

// J − 1 = tr H + tr cof H + det H
fn volume_change(h: mat3x3<f32>) -> f32 {
    return trace(h) + trace(cofactor(h)) + det(h);
}

// F − cof F = H + Hᵀ − tr H I − cof H
fn shear_stress(h: mat3x3<f32>) -> mat3x3<f32> {
    return h + transpose(h) - trace(h) * identity() - cofactor(h);
}

// P = μ (F − cof F) + (λ + μ)(J − 1) cof F
fn neo_hookean_stress(h: mat3x3<f32>, mu: f32, lambda: f32) -> mat3x3<f32> {
    return mu * shear_stress(h)
        + ((lambda + mu) * volume_change(h)) * cofactor(identity() + h);
}

// (½ Δ(I_C − 2J), Δ(J − 1)²) from F to F + D, with s = F : cof D + det D and ΔJ = cof F : D + s:
// (F − cof F) : D + ½ D : D − s and ΔJ (2 (J − 1) + ΔJ)
fn strain_differences(h: mat3x3<f32>, d: mat3x3<f32>) -> vec2<f32> {
    let f = identity() + h;
    let s = double_dot(f, cofactor(d)) + det(d);
    let dj = double_dot(cofactor(f), d) + s;
    let shear = double_dot(shear_stress(h), d) + 0.5 * double_dot(d, d) - s;
    return vec2(shear, dj * (2.0 * volume_change(h) + dj));
}

// Ψ(F + D) − Ψ(F)
fn neo_hookean_energy_difference(h: mat3x3<f32>, d: mat3x3<f32>, mu: f32, lambda: f32) -> f32 {
    let change = strain_differences(h, d);
    return mu * change.x + 0.5 * (lambda + mu) * change.y;
}

// p = (λ + μ)(J − 1) − μ, the factor of ∂cof F/∂F
fn neo_hookean_pressure(h: mat3x3<f32>, mu: f32, lambda: f32) -> f32 {
    return (lambda + mu) * volume_change(h) - mu;
}

// C = ∂P/∂F = μ I₉ + (λ + μ) cof F ⊗ cof F + p ∂cof F/∂F
fn neo_hookean_tangent(h: mat3x3<f32>, mu: f32, lambda: f32) -> Tangent {
    let kappa = lambda + mu;
    let f = identity() + h;
    let p = neo_hookean_pressure(h, mu, lambda);
    let a = cofactor(f);
    // Column k of cof F is F_i × F_j, (i, j, k) cyclic.
    return Tangent(
        mu * identity() + kappa * outer(a[0], a[0]),
        kappa * outer(a[1], a[0]) + p * skew(f[2]),
        mu * identity() + kappa * outer(a[1], a[1]),
        kappa * outer(a[2], a[0]) - p * skew(f[1]),
        kappa * outer(a[2], a[1]) + p * skew(f[0]),
        mu * identity() + kappa * outer(a[2], a[2]),
    );
}
