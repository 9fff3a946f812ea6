// Eigen- and singular values of 3×3 matrices by Jacobi rotations (Golub and Van Loan, §8.5).

struct Eigen {
    values: vec3<f32>,
    vectors: mat3x3<f32>,
}

// (t, c, s) of the rotation that zeroes a_pq: t² + 2 t θ − 1 = 0, θ = (a_qq − a_pp)/(2 a_pq)
fn jacobi_rotation(pp: f32, qq: f32, pq: f32) -> vec3<f32> {
    if (abs(pq) <= 1e-30) {
        return vec3(0.0, 1.0, 0.0);
    }
    let theta = (qq - pp) / (2.0 * pq);
    // Beyond 1e15 the square would overflow, and 1/(2θ) is exact to rounding.
    let root = select(abs(theta), sqrt(theta * theta + 1.0), abs(theta) < 1e15);
    let t = select(-1.0, 1.0, theta >= 0.0) / (abs(theta) + root);
    let c = 1.0 / sqrt(t * t + 1.0);
    return vec3(t, c, t * c);
}

// Eigenvalues in no order, eigenvectors as columns. Five cyclic sweeps reach f32 rounding.
fn symmetric_eigen(m: mat3x3<f32>) -> Eigen {
    var d = vec3(m[0].x, m[1].y, m[2].z);
    var a01 = m[0].y;
    var a02 = m[0].z;
    var a12 = m[1].z;
    var v0 = vec3(1.0, 0.0, 0.0);
    var v1 = vec3(0.0, 1.0, 0.0);
    var v2 = vec3(0.0, 0.0, 1.0);
    for (var sweep = 0; sweep < 5; sweep++) {
        let r01 = jacobi_rotation(d.x, d.y, a01);
        d += vec3(-r01.x, r01.x, 0.0) * a01;
        let b02 = r01.y * a02 - r01.z * a12;
        a12 = r01.z * a02 + r01.y * a12;
        a02 = b02;
        a01 = 0.0;
        let w0 = r01.y * v0 - r01.z * v1;
        v1 = r01.z * v0 + r01.y * v1;
        v0 = w0;

        let r02 = jacobi_rotation(d.x, d.z, a02);
        d += vec3(-r02.x, 0.0, r02.x) * a02;
        a01 = -r02.z * a12;
        a12 = r02.y * a12;
        a02 = 0.0;
        let w1 = r02.y * v0 - r02.z * v2;
        v2 = r02.z * v0 + r02.y * v2;
        v0 = w1;

        let r12 = jacobi_rotation(d.y, d.z, a12);
        d += vec3(0.0, -r12.x, r12.x) * a12;
        let b01 = r12.y * a01 - r12.z * a02;
        a02 = r12.z * a01 + r12.y * a02;
        a01 = b01;
        a12 = 0.0;
        let w2 = r12.y * v1 - r12.z * v2;
        v2 = r12.z * v1 + r12.y * v2;
        v1 = w2;
    }
    return Eigen(d, mat3x3<f32>(v0, v1, v2));
}

// F = U diag(σ) Vᵀ with U and V rotations: the smallest σ, the last, carries the sign of det F.
struct SingularValues {
    u: mat3x3<f32>,
    sigma: vec3<f32>,
    v: mat3x3<f32>,
}

// Of F = I + H. The eigenvectors are those of Fᵀ F − I = H + Hᵀ + Hᵀ H, which keeps small strains.
fn singular_values(h: mat3x3<f32>) -> SingularValues {
    let e = symmetric_eigen(h + transpose(h) + transpose(h) * h);
    // The two largest, in any order.
    let last = select(select(2u, 1u, e.values.y <= e.values.z), 0u,
        e.values.x <= min(e.values.y, e.values.z));
    let v0 = e.vectors[(last + 1u) % 3u];
    let v1 = e.vectors[(last + 2u) % 3u];
    let v2 = cross(v0, v1);
    let f0 = v0 + h * v0;
    let f1 = v1 + h * v1;
    let f2 = v2 + h * v2;
    // Gram–Schmidt on F V, so that U stays a rotation where F is near singular.
    let u0 = normalize_or(f0, vec3(1.0, 0.0, 0.0));
    let u1 = normalize_or(f1 - u0 * dot(u0, f1), orthogonal_to(u0));
    let u2 = cross(u0, u1);
    return SingularValues(
        mat3x3<f32>(u0, u1, u2),
        vec3(dot(u0, f0), dot(u1, f1), dot(u2, f2)),
        mat3x3<f32>(v0, v1, v2),
    );
}

fn normalize_or(v: vec3<f32>, fallback: vec3<f32>) -> vec3<f32> {
    let length = length(v);
    return select(fallback, v / length, length > 1e-18);
}

// A unit vector orthogonal to the unit vector `a`: across its smallest component.
fn orthogonal_to(a: vec3<f32>) -> vec3<f32> {
    let b = abs(a);
    let axis = select(select(vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), b.y <= b.z),
        vec3(1.0, 0.0, 0.0), b.x <= min(b.y, b.z));
    return normalize(cross(a, axis));
}
