// x̄ = X + Σ_k feature_k column_k  (Loper et al. 2015); one thread a point.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> pose_columns: array<f32>;
@group(0) @binding(5) var<storage, read> pose_features: array<f32>;
@group(0) @binding(6) var<storage, read_write> unposed: array<vec3<f32>>;

@compute @workgroup_size(64)
fn pose_blend(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= constants.points) {
        return;
    }
    let at = chunk.first + id.y;
    var x = vec3<f32>();
    for (var k = 0u; k < constants.features; k++) {
        let c = 3u * (k * constants.points + i);
        let column = vec3(pose_columns[c], pose_columns[c + 1u], pose_columns[c + 2u]);
        x += pose_features[at * constants.features + k] * column;
    }
    unposed[batch[at].instance * constants.points + i] = points[i].position + x;
}
