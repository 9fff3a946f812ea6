// The solver's Hessian of one cubature point, all pairs a ≥ b of its own blocks:
//   H_ab = (m/h̃²) J_aᵀ J_b + w (∇U_aᵀ ⊗ I) C (∇U_b ⊗ I),  m = ρ w, the latter between handles only,
//   J: c_j: w_j I     ω_j: −w_j [R_j (T − J_j)]×     φ_h: U_h B, B = Σ w_j R_j
// One workgroup a point: first what each block's J is made of, then each thread takes a block b, its Y = C (∇U_b ⊗ I)
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

// What J of each block is made of: c: (0, w)     ω: (w R_j (T − J_j), 0)     φ: (∇U, U)
var<workgroup> local: array<vec4<f32>, MAX_BLOCKS>;

@compute @workgroup_size(32)
fn point_hessian(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let i = group.x;
    let state = batch[chunk.first + group.y];
    let point = points[i];
    let at = state.slot * constants.points + i;
    let rows = 2u * point.bones;
    let blocks = rows + point.handles;

    for (var b = thread; b < blocks; b += 32u) {
        if (b >= rows) {
            let u = influences[point.first_influence + point.bones + b - rows].weight;
            local[b] = vec4(handle_gradients[point.first_gradient + b - rows].gradient, u);
        } else {
            let w = influences[point.first_influence + b / 2u];
            let f = state.slot * constants.bones + w.index;
            if (b % 2u == 0u) {
                local[b] = vec4(0.0, 0.0, 0.0, w.weight);
            } else {
                let arm = frames[f].rotation * (motion[at].unposed - frames[f].joint);
                local[b] = vec4(w.weight * arm, 0.0);
            }
        }
    }
    workgroupBarrier();

    let inertia = constants.density * point.measure * state.mass_rate;
    let blended = motion[at].blended;
    let first = group.y * constants.local_pairs + point.first_pair;
    for (var b = thread; b < blocks; b += 32u) {
        let own = local[b];
        // (m/h̃²) J_b, and Y_i = w Σ_j C_ij ∇U_j
        var j = (inertia * own.w) * identity();
        var y0 = mat3x3<f32>();
        var y1 = mat3x3<f32>();
        var y2 = mat3x3<f32>();
        if (b >= rows) {
            j = (inertia * own.w) * blended;
            let g = point.measure * own.xyz;
            let c = tangent[at];
            y0 = g.x * c.c00 + g.y * transpose(c.c10) + g.z * transpose(c.c20);
            y1 = g.x * c.c10 + g.y * c.c11 + g.z * transpose(c.c21);
            y2 = g.x * c.c20 + g.y * c.c21 + g.z * c.c22;
        } else if (b % 2u == 1u) {
            j = -inertia * skew(own.xyz);
        }
        let unposed_j = transpose(blended) * j;
        // Partners a = b, b + 1, … around a circle, half of it: every pair once, equal work a thread.
        let half = blocks / 2u;
        let partners = half + u32(blocks % 2u == 1u || b < half);
        for (var k = 0u; k < partners; k++) {
            let a = select(b + k, b + k - blocks, b + k >= blocks);
            let other = local[a];
            var h: mat3x3<f32>;
            if (a >= rows) {
                h = other.w * unposed_j + other.x * y0 + other.y * y1 + other.z * y2;
            } else if (a % 2u == 0u) {
                h = other.w * j;
            } else {
                // (−[a]×)ᵀ = [a]×
                h = mat3x3<f32>(cross(other.xyz, j[0]), cross(other.xyz, j[1]), cross(other.xyz, j[2]));
            }
            if (a >= b) {
                point_hessians[first + a * (a + 1u) / 2u + b] = h;
            } else {
                point_hessians[first + b * (b + 1u) / 2u + a] = transpose(h);
            }
        }
    }
}
