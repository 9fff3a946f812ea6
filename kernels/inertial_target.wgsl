// ŷ = Σ_{k≥1} c_k (x(qⁿ⁻ᵏ) − x(qⁿ)) of every cubature point at a step's start (method §5): with T at qⁿ and
// ΔT_k = Σ_h U_h c_k (φⁿ⁻ᵏ − φⁿ)_h,
//   ŷ = Σ_j w_j ( A_j (T − J_j) + b_j + Σ_k R_j(qⁿ⁻ᵏ) ΔT_k ),  [A | b] = Σ_k c_k ([R | c](qⁿ⁻ᵏ) − [R | c](qⁿ))
// One thread a point. The start's own displacement, which is none, gives way to it.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read> frames: array<Frame>;
@group(0) @binding(6) var<storage, read> past_frames: array<PastFrame>;
@group(0) @binding(7) var<storage, read> past_handles: array<PastHandle>;
@group(0) @binding(8) var<storage, read_write> motion: array<Motion>;

@compute @workgroup_size(64)
fn inertial_target(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= constants.points) {
        return;
    }
    let state = batch[chunk.first + id.y];
    let point = points[i];
    let at = state.slot * constants.points + i;
    let unposed = motion[at].unposed;
    var first = vec3<f32>();
    var second = vec3<f32>();
    var third = vec3<f32>();
    for (var k = 0u; k < point.handles; k++) {
        let u = influences[point.first_influence + point.bones + k];
        let phi = past_handles[state.instance * constants.handles + u.index];
        first += u.weight * phi.first;
        second += u.weight * phi.second;
        third += u.weight * phi.third;
    }
    var y = vec3<f32>();
    for (var k = 0u; k < point.bones; k++) {
        let w = influences[point.first_influence + k];
        let past = past_frames[state.instance * constants.bones + w.index];
        let joint = frames[state.slot * constants.bones + w.index].joint;
        y += w.weight * (past.turn * (unposed - joint) + past.shift
            + past.first * first + past.second * second + past.third * third);
    }
    motion[at].displacement = y;
}
