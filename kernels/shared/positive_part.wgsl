// A tangent less its negative eigenvalues: its nearest positive semi-definite matrix.

// The 9×9 matrix and its eigenvectors as columns, row by row.
struct Matrix9 {
    rows: array<array<f32, 9>, 9>,
}

fn set_block(m: ptr<function, Matrix9>, i: u32, j: u32, block: mat3x3<f32>) {
    for (var column = 0u; column < 3u; column++) {
        for (var row = 0u; row < 3u; row++) {
            (*m).rows[3u * i + row][3u * j + column] = block[column][row];
            (*m).rows[3u * j + column][3u * i + row] = block[column][row];
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
        var pivot = l.rows[j][j];
        for (var k = 0u; k < j; k++) {
            pivot -= l.rows[j][k] * l.rows[j][k];
        }
        if (!(pivot > 0.0)) {
            return false;
        }
        l.rows[j][j] = sqrt(pivot);
        for (var i = j + 1u; i < 9u; i++) {
            var rest = l.rows[i][j];
            for (var k = 0u; k < j; k++) {
                rest -= l.rows[i][k] * l.rows[j][k];
            }
            l.rows[i][j] = rest / l.rows[j][j];
        }
    }
    return true;
}

// One Jacobi rotation: zeroes a_pq, and turns columns p and q of the eigenvectors.
fn rotate(a: ptr<function, Matrix9>, v: ptr<function, Matrix9>, p: u32, q: u32) {
    let r = jacobi_rotation((*a).rows[p][p], (*a).rows[q][q], (*a).rows[p][q]);
    for (var k = 0u; k < 9u; k++) {
        let kp = (*a).rows[k][p];
        let kq = (*a).rows[k][q];
        (*a).rows[k][p] = r.y * kp - r.z * kq;
        (*a).rows[k][q] = r.z * kp + r.y * kq;
        let vp = (*v).rows[k][p];
        let vq = (*v).rows[k][q];
        (*v).rows[k][p] = r.y * vp - r.z * vq;
        (*v).rows[k][q] = r.z * vp + r.y * vq;
    }
    for (var k = 0u; k < 9u; k++) {
        let pk = (*a).rows[p][k];
        let qk = (*a).rows[q][k];
        (*a).rows[p][k] = r.y * pk - r.z * qk;
        (*a).rows[q][k] = r.z * pk + r.y * qk;
    }
    (*a).rows[p][q] = 0.0;
    (*a).rows[q][p] = 0.0;
}

// C⁺ = C − Σ min(λ, 0) V ⊗ V. Seven cyclic sweeps (Golub and Van Loan, §8.5) reach f32 rounding.
fn positive_part(c: Tangent) -> Tangent {
    var a = full_matrix(c);
    if (is_positive_definite(a)) {
        return c;
    }
    var v: Matrix9;
    for (var i = 0u; i < 9u; i++) {
        v.rows[i][i] = 1.0;
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
        let value = a.rows[k][k];
        if (value < 0.0) {
            let mode = mat3x3<f32>(
                v.rows[0][k], v.rows[1][k], v.rows[2][k],
                v.rows[3][k], v.rows[4][k], v.rows[5][k],
                v.rows[6][k], v.rows[7][k], v.rows[8][k],
            );
            out = add_mode(out, -value, mode);
        }
    }
    return out;
}
