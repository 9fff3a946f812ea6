// The posed skin, relative to the instance's origin: x = Σ_j w_j ( R_j (T − J_j) + c_j ).
// One thread a vertex.

struct SkinVertex {
    position: vec3<f32>,
    normal: vec3<f32>,
}

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read> frames: array<Frame>;
@group(0) @binding(6) var<storage, read> handles: array<Handle>;
@group(0) @binding(7) var<storage, read> unposed: array<vec3<f32>>;
@group(0) @binding(8) var<storage, read_write> skin_vertices: array<SkinVertex>;

@compute @workgroup_size(64)
fn skin(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= constants.points) {
        return;
    }
    let state = batch[chunk.first + id.y];
    let point = points[i];
    let at = state.instance * constants.points + i;
    let t = unposed_position(point, unposed[at], state.slot * constants.handles);
    skin_vertices[state.instance * constants.skin_stride + i].position =
        skinned_position(point, t, state.slot * constants.bones);
}
