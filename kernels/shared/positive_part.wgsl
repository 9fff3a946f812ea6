// A tangent less its negative eigenvalues: its nearest positive semi-definite matrix.

// A 9×9 matrix, row by row. Flat: FXC, wgpu's compiler on some of Windows, makes nothing of arrays of arrays.
alias Matrix9 = array<f32, 81>;

fn set_block(m: ptr<function, Matrix9>, i: u32, j: u32, block: mat3x3<f32>) {
    for (var column = 0u; column < 3u; column++) {
        for (var row = 0u; row < 3u; row++) {
            (*m)[9u * (3u * i + row) + 3u * j + column] = block[column][row];
            (*m)[9u * (3u * j + column) + 3u * i + row] = block[column][row];
        }
    }
}

fn full_matrix(c: Tangent) -> Matrix9 {
    var m: Matrix9;
    set_block(&m, 0u, 0u, c.c00);
    set_block(&m, 1u, 0u, c.c10);
    set_block(&m, 1u, 1u, c.c11);
    set_block(&m, 2u, 0u, c.c20);
    set_block(&m, 2u, 1u, c.c21);
    set_block(&m, 2u, 2u, c.c22);
    return m;
}

// Whether the Cholesky factorisation exists.
fn is_positive_definite(m: Matrix9) -> bool {
    var l = m;
    for (var j = 0u; j < 9u; j++) {
        var pivot = l[9u * j + j];
        for (var k = 0u; k < j; k++) {
            pivot -= l[9u * j + k] * l[9u * j + k];
        }
        if (!(pivot > 0.0)) {
            return false;
        }
        l[9u * j + j] = sqrt(pivot);
        for (var i = j + 1u; i < 9u; i++) {
            var rest = l[9u * i + j];
            for (var k = 0u; k < j; k++) {
                rest -= l[9u * i + k] * l[9u * j + k];
            }
            l[9u * i + j] = rest / l[9u * j + j];
        }
    }
    return true;
}

// One Jacobi rotation: zeroes a_pq, and turns columns p and q of the eigenvectors.
fn rotate(a: ptr<function, Matrix9>, v: ptr<function, Matrix9>, p: u32, q: u32) {
    let r = jacobi_rotation((*a)[9u * p + p], (*a)[9u * q + q], (*a)[9u * p + q]);
    for (var k = 0u; k < 9u; k++) {
        let kp = (*a)[9u * k + p];
        let kq = (*a)[9u * k + q];
        (*a)[9u * k + p] = r.y * kp - r.z * kq;
        (*a)[9u * k + q] = r.z * kp + r.y * kq;
        let vp = (*v)[9u * k + p];
        let vq = (*v)[9u * k + q];
        (*v)[9u * k + p] = r.y * vp - r.z * vq;
        (*v)[9u * k + q] = r.z * vp + r.y * vq;
    }
    for (var k = 0u; k < 9u; k++) {
        let pk = (*a)[9u * p + k];
        let qk = (*a)[9u * q + k];
        (*a)[9u * p + k] = r.y * pk - r.z * qk;
        (*a)[9u * q + k] = r.z * pk + r.y * qk;
    }
    (*a)[9u * p + q] = 0.0;
    (*a)[9u * q + p] = 0.0;
}

// C⁺ = C − Σ min(λ, 0) V ⊗ V. Seven cyclic sweeps (Golub and Van Loan, §8.5) reach f32 rounding.
fn positive_part(c: Tangent) -> Tangent {
    var a = full_matrix(c);
    if (is_positive_definite(a)) {
        return c;
    }
    var v: Matrix9;
    for (var i = 0u; i < 9u; i++) {
        v[9u * i + i] = 1.0;
    }
    for (var sweep = 0; sweep < 7; sweep++) {
        for (var q = 1u; q < 9u; q++) {
            for (var p = 0u; p < q; p++) {
                rotate(&a, &v, p, q);
            }
        }
    }
    var out = c;
    for (var k = 0u; k < 9u; k++) {
        let value = a[9u * k + k];
        if (value < 0.0) {
            let mode = mat3x3<f32>(
                v[k], v[9u + k], v[18u + k],
                v[27u + k], v[36u + k], v[45u + k],
                v[54u + k], v[63u + k], v[72u + k],
            );
            out = add_mode(out, -value, mode);
        }
    }
    return out;
}
