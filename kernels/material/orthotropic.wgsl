// Ψ = Ψ₀(F) + ½ E : (K ∘ E) + (c/2) g(Q), Q = E : (A ∘ E), in the axes G (normal to the skin, along the bone, around
// it), Ψ₀ being shared/neo_hookean.wgsl and ∘ the product by entries.
// g(Q) = e^Q − 1 up to Q_max, then e^Q_max (1 + Q − Q_max) − 1 (Li and Barbič 2014; Fung et al. 1979).
// K_ij = √k_i √k_j, A_ij = √a_i √a_j.

struct OrthotropicParameters {
    mu: f32,                // Lamé's, of the ground substance, Pa
    lambda: f32,
    saturation: f32,        // c, Pa
    saturation_limit: f32,  // Q_max
    root_fibre_moduli: vec3<f32>,      // √k, √Pa
    root_saturation_rates: vec3<f32>,  // √a
}

alias MaterialParameters = OrthotropicParameters;

struct Fibres {
    moduli: mat3x3<f32>,     // W = K + c g′ A
    direction: mat3x3<f32>,  // A ∘ E
    growth: f32,             // c g″ = c e^Q, 0 past the limit
}

// A ∘ B
fn by_entries(a: mat3x3<f32>, b: mat3x3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(a[0] * b[0], a[1] * b[1], a[2] * b[2]);
}

fn fibre_moduli() -> mat3x3<f32> {
    return outer(material.root_fibre_moduli, material.root_fibre_moduli);
}

fn saturation_rates() -> mat3x3<f32> {
    return outer(material.root_saturation_rates, material.root_saturation_rates);
}

// E = ½ (H + Hᵀ + Hᵀ H) in the axes G
fn green_strain(h: mat3x3<f32>, axes: mat3x3<f32>) -> mat3x3<f32> {
    return 0.5 * (transpose(axes) * (h + transpose(h) + transpose(h) * h) * axes);
}

fn fibres_at(e: mat3x3<f32>) -> Fibres {
    let limit = material.saturation_limit;
    let direction = by_entries(saturation_rates(), e);
    let q = double_dot(direction, e);
    let slope = material.saturation * exp(min(q, limit));
    let moduli = fibre_moduli() + slope * saturation_rates();
    return Fibres(moduli, direction, select(0.0, slope, q < limit));
}

// P = P₀ + F G S Gᵀ, S = W ∘ E
fn pk1_stress(h: mat3x3<f32>, axes: mat3x3<f32>) -> mat3x3<f32> {
    let e = green_strain(h, axes);
    let s = axes * by_entries(fibres_at(e).moduli, e) * transpose(axes);
    return neo_hookean_stress(h, material.mu, material.lambda) + s + h * s;
}

// g(Q + ΔQ) − g(Q) = e^min(Q, Q_max) (e^x − 1) + e^Q_max (ΔQ − x), x the part of ΔQ below Q_max
fn saturation_difference(q: f32, change: f32) -> f32 {
    let limit = material.saturation_limit;
    let last = q + change;
    var inner = change;
    if (q >= limit) {
        inner = select(0.0, last - limit, last < limit);
    } else if (last >= limit) {
        inner = limit - q;
    }
    return exp(min(q, limit)) * (inner * mean_exponential(inner)) + exp(limit) * (change - inner);
}

// With ΔE = sym(Fᵀ D) + ½ Dᵀ D, a form E : (M ∘ E) changes by ΔE : (M ∘ (2 E + ΔE)).
fn energy_difference(h: mat3x3<f32>, d: mat3x3<f32>, axes: mat3x3<f32>) -> f32 {
    let e = green_strain(h, axes);
    let fd = d + transpose(h) * d;
    let change = 0.5 * (transpose(axes) * (fd + transpose(fd) + transpose(d) * d) * axes);
    let between = 2.0 * e + change;
    let fibres = double_dot(change, by_entries(fibre_moduli(), between));
    let q = double_dot(e, by_entries(saturation_rates(), e));
    let q_change = double_dot(change, by_entries(saturation_rates(), between));
    let saturating = material.saturation * saturation_difference(q, q_change);
    return neo_hookean_energy_difference(h, d, material.mu, material.lambda)
        + 0.5 * (fibres + saturating);
}

// Between columns i and j of F G: S_ij I + ½ W_ij f_j f_iᵀ + 2 c g″ t_i t_jᵀ, t = F G (A ∘ E).
fn fibre_block(f: Fibres, e: mat3x3<f32>, fg: mat3x3<f32>, t: mat3x3<f32>, i: u32, j: u32) -> mat3x3<f32> {
    let w = f.moduli[i][j];
    return (w * e[i][j]) * identity() + 0.5 * w * outer(fg[j], fg[i])
        + 2.0 * f.growth * outer(t[i], t[j]);
}

// ½ Σ_m W_mi f_m f_mᵀ, which only a column has with itself.
fn column_block(f: Fibres, fg: mat3x3<f32>, i: u32) -> mat3x3<f32> {
    return 0.5 * (f.moduli[i].x * outer(fg[0], fg[0]) + f.moduli[i].y * outer(fg[1], fg[1])
        + f.moduli[i].z * outer(fg[2], fg[2]));
}

// Σ_kl G_ik G_jl B_kl over the blocks B of columns of F G: the block of columns i and j of F.
fn turned_block(b: array<mat3x3<f32>, 9>, axes: mat3x3<f32>, i: u32, j: u32) -> mat3x3<f32> {
    var blocks = b;
    var out = mat3x3<f32>();
    for (var k = 0u; k < 3u; k++) {
        for (var l = 0u; l < 3u; l++) {
            out += (axes[k][i] * axes[l][j]) * blocks[3u * k + l];
        }
    }
    return out;
}

// C = C₀ + the fibres' part, less its negative eigenvalues.
fn projected_tangent(h: mat3x3<f32>, axes: mat3x3<f32>) -> Tangent {
    let e = green_strain(h, axes);
    let f = fibres_at(e);
    let fg = axes + h * axes;
    let t = fg * f.direction;
    var b: array<mat3x3<f32>, 9>;
    for (var i = 0u; i < 3u; i++) {
        for (var j = 0u; j < 3u; j++) {
            b[3u * i + j] = fibre_block(f, e, fg, t, i, j);
        }
        b[4u * i] += column_block(f, fg, i);
    }
    let fibres = Tangent(
        turned_block(b, axes, 0u, 0u),
        turned_block(b, axes, 1u, 0u),
        turned_block(b, axes, 1u, 1u),
        turned_block(b, axes, 2u, 0u),
        turned_block(b, axes, 2u, 1u),
        turned_block(b, axes, 2u, 2u),
    );
    let ground = neo_hookean_tangent(h, material.mu, material.lambda);
    return positive_part(add_scaled(ground, 1.0, fibres));
}
