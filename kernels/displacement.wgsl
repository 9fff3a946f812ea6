// d_i = x_i(q) − x_i(q_base) from increments only, never from two world positions:
//   T_base = x̄ + Σ U φ_base,  ΔT = Σ U Δφ,  d = Σ_j w_j ( ΔR_j (T_base − J_j) + R_j ΔT + Δc_j )
// with T = T_base + ΔT and B = Σ_j w_j R_j for the stages that follow.
// One thread a cubature point.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read> frames: array<Frame>;
@group(0) @binding(6) var<storage, read> handles: array<Handle>;
@group(0) @binding(7) var<storage, read> unposed: array<vec3<f32>>;
@group(0) @binding(8) var<storage, read_write> motion: array<Motion>;

@compute @workgroup_size(64)
fn displacement(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= constants.points) {
        return;
    }
    let state = batch[chunk.first + id.y];
    let point = points[i];

    var t_base = unposed[state.instance * constants.points + i];
    var t_increment = vec3<f32>();
    let first_handle = point.first_influence + point.bones;
    for (var k = 0u; k < point.handles; k++) {
        let u = influences[first_handle + k];
        let phi = handles[state.slot * constants.handles + u.index];
        t_base += u.weight * phi.displacement;
        t_increment += u.weight * phi.increment;
    }

    var d = vec3<f32>();
    var blended = mat3x3<f32>();
    for (var k = 0u; k < point.bones; k++) {
        let w = influences[point.first_influence + k];
        let f = state.slot * constants.bones + w.index;
        let rotation = frames[f].rotation;
        d += w.weight * (frames[f].rotation_increment * (t_base - frames[f].joint)
            + rotation * t_increment + frames[f].position_increment);
        blended += w.weight * rotation;
    }
    motion[state.slot * constants.points + i] = Motion(d, t_base + t_increment, blended);
}
