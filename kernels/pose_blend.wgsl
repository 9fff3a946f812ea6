// x̄ = X + Σ_k feature_k column_k + Σ_v E_v u_v  (Loper et al. 2015; u are a host's offsets of the skin); one thread a
// point. A skin vertex has a single share, the whole of its own offset.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> pose_columns: array<f32>;
@group(0) @binding(5) var<storage, read> pose_features: array<f32>;
@group(0) @binding(6) var<storage, read> influences: array<Influence>;
@group(0) @binding(7) var<storage, read> pose_offsets: array<f32>;
@group(0) @binding(8) var<storage, read_write> unposed: array<vec3<f32>>;

@compute @workgroup_size(64)
fn pose_blend(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= constants.points) {
        return;
    }
    let at = chunk.first + id.y;
    let state = batch[at];
    let point = points[i];
    var x = vec3<f32>();
    for (var k = 0u; k < constants.features; k++) {
        let c = 3u * (k * constants.points + i);
        let column = vec3(pose_columns[c], pose_columns[c + 1u], pose_columns[c + 2u]);
        x += pose_features[at * constants.features + k] * column;
    }
    if (state.has_offsets != 0u) {
        let first = state.instance * constants.offset_vertices;
        for (var k = point.first_share; k < point.first_share + point.shares; k++) {
            let u = 3u * (first + influences[k].index);
            let offset = vec3(pose_offsets[u], pose_offsets[u + 1u], pose_offsets[u + 2u]);
            x += influences[k].weight * offset;
        }
    }
    unposed[state.instance * constants.points + i] = point.position + x;
}
