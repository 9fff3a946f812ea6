// The solver's Hessian of one cubature point, all pairs a ≥ b of its own blocks:
//   H_ab = (m/h²) J_aᵀ J_b + w (∇U_aᵀ ⊗ I) C (∇U_b ⊗ I),  m = ρ w, the latter between handles only,
//   J: c_j: w_j I     ω_j: −w_j [R_j (T − J_j)]×     φ_h: U_h B, B = Σ w_j R_j
// One workgroup a point: first each block's J, then each thread takes a block b, its Y = C (∇U_b ⊗ I)
// and half of the others as a.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read> handle_gradients: array<HandleGradient>;
@group(0) @binding(6) var<storage, read> frames: array<Frame>;
@group(0) @binding(7) var<storage, read> motion: array<Motion>;
@group(0) @binding(8) var<storage, read> tangent: array<Tangent>;
@group(0) @binding(9) var<storage, read_write> point_hessians: array<mat3x3<f32>>;

// The most blocks a point may have.
const MAX_BLOCKS = 192u;

var<workgroup> jacobian: array<mat3x3<f32>, MAX_BLOCKS>;
var<workgroup> basis_gradient: array<vec3<f32>, MAX_BLOCKS>;  // ∇U, zero for bones

@compute @workgroup_size(32)
fn point_hessian(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = group.x;
    let state = batch[chunk.first + group.y];
    let point = points[i];
    let at = state.slot * constants.points + i;
    let first_frame = state.slot * constants.bones;
    let rows = 2u * point.bones;
    let blocks = rows + point.handles;

    for (var b = lane; b < blocks; b += 32u) {
        var j = mat3x3<f32>();
        var g = vec3<f32>();
        if (b < rows) {
            let w = influences[point.first_influence + b / 2u];
            let f = first_frame + w.index;
            j = w.weight * identity();
            if (b % 2u == 1u) {
                j = -w.weight * skew(frames[f].rotation * (motion[at].unposed - frames[f].joint));
            }
        } else {
            for (var k = 0u; k < point.bones; k++) {
                let w = influences[point.first_influence + k];
                j += w.weight * frames[first_frame + w.index].rotation;
            }
            j = influences[point.first_influence + point.bones + b - rows].weight * j;
            g = handle_gradients[point.first_gradient + b - rows].gradient;
        }
        jacobian[b] = j;
        basis_gradient[b] = g;
    }
    workgroupBarrier();

    let inertia = constants.density * point.measure * state.mass_rate;
    let first = group.y * constants.local_pairs + point.first_pair;
    for (var b = lane; b < blocks; b += 32u) {
        let j = inertia * jacobian[b];
        // Y_i = w Σ_j C_ij ∇U_j
        var y0 = mat3x3<f32>();
        var y1 = mat3x3<f32>();
        var y2 = mat3x3<f32>();
        if (b >= rows) {
            let g = point.measure * basis_gradient[b];
            let c = tangent[at];
            y0 = g.x * c.c00 + g.y * transpose(c.c10) + g.z * transpose(c.c20);
            y1 = g.x * c.c10 + g.y * c.c11 + g.z * transpose(c.c21);
            y2 = g.x * c.c20 + g.y * c.c21 + g.z * c.c22;
        }
        // Partners a = b, b + 1, … around a circle, half of it: every pair once, equal work a thread.
        let half = blocks / 2u;
        let partners = half + u32(blocks % 2u == 1u || b < half);
        for (var k = 0u; k < partners; k++) {
            let a = select(b + k, b + k - blocks, b + k >= blocks);
            let g = basis_gradient[a];
            let h = transpose(jacobian[a]) * j + g.x * y0 + g.y * y1 + g.z * y2;
            if (a >= b) {
                point_hessians[first + a * (a + 1u) / 2u + b] = h;
            } else {
                point_hessians[first + b * (b + 1u) / 2u + a] = transpose(h);
            }
        }
    }
}
