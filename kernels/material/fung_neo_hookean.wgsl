// Ψ = μ/(2b) g(b Q) + λ/2 (J − 1)², Q = I_C − 4J + J²: the ground substance (shared/neo_hookean.wgsl) with μ g′ for μ, and
// 2 μ b g″ A ⊗ A more in C, A = ½ ∂Q/∂F (Demiray 1972, after Fung).
// g(y) = e^y − 1 up to y_max, then e^y_max (1 + z + ½ z²) − 1, z = y − y_max: g″ = e^min(y, y_max), g′ = g″ (1 + max(z, 0)).
// Isotropic, so that no axes matter.

struct FungNeoHookeanParameters {
    mu: f32,                // Lamé's of small strains, Pa
    lambda: f32,
    stiffening: f32,        // b
    stiffening_limit: f32,  // y_max
}

alias MaterialParameters = FungNeoHookeanParameters;

// y = b Q, and Q = H : H − 2 tr cof H − 2 det H + (J − 1)²
fn exponent_at(h: mat3x3<f32>) -> f32 {
    let volume = volume_change(h);
    return material.stiffening
        * (double_dot(h, h) - 2.0 * (trace(cofactor(h)) + det(h)) + volume * volume);
}

// (μ g′, 2 μ b g″)
fn stiffened(h: mat3x3<f32>) -> vec2<f32> {
    let y = exponent_at(h);
    let limit = material.stiffening_limit;
    let second = material.mu * exp(min(y, limit));
    return vec2(second * (1.0 + max(y - limit, 0.0)), 2.0 * material.stiffening * second);
}

fn pk1_stress(h: mat3x3<f32>, axes: mat3x3<f32>) -> mat3x3<f32> {
    return neo_hookean_stress(h, stiffened(h).x, material.lambda);
}

// (g(y + b ΔQ) − g(y))/b = ΔQ (e^min(y, y_max) (e^x − 1)/x t + e^y_max (1 + ½ (z + z′)) (1 − t)), x the part of b ΔQ below
// y_max and t its share
fn stiffening_difference(y: f32, change: f32) -> f32 {
    let limit = material.stiffening_limit;
    let whole = material.stiffening * change;
    let last = y + whole;
    var inner = whole;
    if (y >= limit) {
        inner = select(0.0, last - limit, last < limit);
    } else if (last >= limit) {
        inner = limit - y;
    }
    var share = 1.0;
    if (inner != whole) {
        share = inner / whole;
    }
    let beyond = max(y - limit, 0.0) + max(last - limit, 0.0);
    return change * (exp(min(y, limit)) * mean_exponential(inner) * share
        + exp(limit) * (1.0 + 0.5 * beyond) * (1.0 - share));
}

fn energy_difference(h: mat3x3<f32>, d: mat3x3<f32>, axes: mat3x3<f32>) -> f32 {
    let change = strain_differences(h, d);
    let strain = 2.0 * change.x + change.y;
    return 0.5 * (material.mu * stiffening_difference(exponent_at(h), strain)
        + material.lambda * change.y);
}

// C less its negative eigenvalues.
fn projected_tangent(h: mat3x3<f32>, axes: mat3x3<f32>) -> Tangent {
    let s = stiffened(h);
    return projected_neo_hookean_tangent(h, s.x, material.lambda, s.y);
}
