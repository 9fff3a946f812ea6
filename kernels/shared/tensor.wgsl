// 3×3 algebra. A tangent C = ∂P/∂F is kept as its blocks C_ij = ∂P_i/∂F_j over columns i ≥ j; C is
// symmetric, so that C_ji = C_ijᵀ.

struct Tangent {
    c00: mat3x3<f32>,
    c10: mat3x3<f32>,
    c11: mat3x3<f32>,
    c20: mat3x3<f32>,
    c21: mat3x3<f32>,
    c22: mat3x3<f32>,
}

fn identity() -> mat3x3<f32> {
    return mat3x3<f32>(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
}

fn outer(a: vec3<f32>, b: vec3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(a * b.x, a * b.y, a * b.z);
}

// [v]× with [v]× a = v × a
fn skew(v: vec3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(0.0, v.z, -v.y, -v.z, 0.0, v.x, v.y, -v.x, 0.0);
}

fn trace(m: mat3x3<f32>) -> f32 {
    return m[0].x + m[1].y + m[2].z;
}

// A : B
fn double_dot(a: mat3x3<f32>, b: mat3x3<f32>) -> f32 {
    return dot(a[0], b[0]) + dot(a[1], b[1]) + dot(a[2], b[2]);
}

// ∂ det F/∂F
fn cofactor(f: mat3x3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(cross(f[1], f[2]), cross(f[2], f[0]), cross(f[0], f[1]));
}

fn det(f: mat3x3<f32>) -> f32 {
    return dot(f[0], cross(f[1], f[2]));
}

// C : A
fn contract(c: Tangent, a: mat3x3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(
        c.c00 * a[0] + a[1] * c.c10 + a[2] * c.c20,
        c.c10 * a[0] + c.c11 * a[1] + a[2] * c.c21,
        c.c20 * a[0] + c.c21 * a[1] + c.c22 * a[2],
    );
}

// s C
fn scaled(c: Tangent, s: f32) -> Tangent {
    return Tangent(s * c.c00, s * c.c10, s * c.c11, s * c.c20, s * c.c21, s * c.c22);
}

// C + s D
fn add_scaled(c: Tangent, s: f32, d: Tangent) -> Tangent {
    return Tangent(
        c.c00 + s * d.c00, c.c10 + s * d.c10, c.c11 + s * d.c11,
        c.c20 + s * d.c20, c.c21 + s * d.c21, c.c22 + s * d.c22,
    );
}

// C + s Q ⊗ Q
fn add_mode(c: Tangent, s: f32, q: mat3x3<f32>) -> Tangent {
    let r = s * q;
    return Tangent(
        c.c00 + outer(r[0], q[0]), c.c10 + outer(r[1], q[0]), c.c11 + outer(r[1], q[1]),
        c.c20 + outer(r[2], q[0]), c.c21 + outer(r[2], q[1]), c.c22 + outer(r[2], q[2]),
    );
}
