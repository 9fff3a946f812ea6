// The solver's Hessian of one cubature point, all pairs a ≥ b of its own blocks:
//   H_ab = (m/h²) J_aᵀ J_b + w (∇U_aᵀ ⊗ I) C (∇U_b ⊗ I),  m = ρ w, the latter between handles only,
//   J: c_j: w_j I     ω_j: −w_j [R_j (T − J_j)]×     φ_h: U_h B, B = Σ w_j R_j
// One workgroup a point: first each block's J and Y = C (∇U ⊗ I), then each thread takes pairs.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read> handle_gradients: array<HandleGradient>;
@group(0) @binding(6) var<storage, read> frames: array<Frame>;
@group(0) @binding(7) var<storage, read> motion: array<Motion>;
@group(0) @binding(8) var<storage, read> tangent: array<Tangent>;
@group(0) @binding(9) var<storage, read_write> point_hessians: array<f32>;

// The most blocks a point may have.
const MAX_BLOCKS = 64u;

var<workgroup> jacobian: array<mat3x3<f32>, MAX_BLOCKS>;
var<workgroup> y0: array<mat3x3<f32>, MAX_BLOCKS>;
var<workgroup> y1: array<mat3x3<f32>, MAX_BLOCKS>;
var<workgroup> y2: array<mat3x3<f32>, MAX_BLOCKS>;

@compute @workgroup_size(64)
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

    if (lane < rows) {
        let w = influences[point.first_influence + lane / 2u];
        let f = first_frame + w.index;
        let arm = frames[f].rotation * (motion[at].unposed - frames[f].joint);
        if (lane % 2u == 0u) {
            jacobian[lane] = w.weight * identity();
        } else {
            jacobian[lane] = -w.weight * skew(arm);
        }
    } else if (lane < blocks) {
        let k = lane - rows;
        var b = mat3x3<f32>();
        for (var j = 0u; j < point.bones; j++) {
            let w = influences[point.first_influence + j];
            b += w.weight * frames[first_frame + w.index].rotation;
        }
        jacobian[lane] = influences[point.first_influence + point.bones + k].weight * b;
        let g = handle_gradients[point.first_gradient + k].gradient;
        let c = tangent[at];
        // Column block of C against ∇U: Y_i = Σ_j C_ij ∇U_j
        y0[lane] = g.x * c.c00 + g.y * transpose(c.c10) + g.z * transpose(c.c20);
        y1[lane] = g.x * c.c10 + g.y * c.c11 + g.z * transpose(c.c21);
        y2[lane] = g.x * c.c20 + g.y * c.c21 + g.z * c.c22;
    }
    workgroupBarrier();

    let inertia = constants.density * point.measure * state.mass_rate;
    let pairs = blocks * (blocks + 1u) / 2u;
    let first = 9u * (group.y * constants.local_pairs + point.first_pair);
    for (var pair = lane; pair < pairs; pair += 64u) {
        // Row a of a triangle stored row by row: the largest with a (a + 1)/2 ≤ pair.
        var a = u32((sqrt(8.0 * f32(pair) + 1.0) - 1.0) * 0.5);
        a -= u32(a * (a + 1u) / 2u > pair);
        a += u32((a + 1u) * (a + 2u) / 2u <= pair);
        let b = pair - a * (a + 1u) / 2u;
        var h = inertia * (transpose(jacobian[a]) * jacobian[b]);
        if (b >= rows) {
            let g = handle_gradients[point.first_gradient + a - rows].gradient;
            h += point.measure * (g.x * y0[b] + g.y * y1[b] + g.z * y2[b]);
        }
        let out = first + 9u * pair;
        for (var column = 0u; column < 3u; column++) {
            point_hessians[out + 3u * column] = h[column].x;
            point_hessians[out + 3u * column + 1u] = h[column].y;
            point_hessians[out + 3u * column + 2u] = h[column].z;
        }
    }
}
