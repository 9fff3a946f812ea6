// n = Σ (b − v) × (c − v) over the triangles (v, b, c) around a vertex, made a unit vector: the
// area-weighted normal, zero where there is none. One thread a vertex.

struct SkinVertex {
    position: vec3<f32>,
    normal: vec3<f32>,
}

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> one_ring_rows: array<u32>;
@group(0) @binding(4) var<storage, read> one_ring_edges: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> skin_vertices: array<SkinVertex>;

@compute @workgroup_size(64)
fn normals(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= constants.points) {
        return;
    }
    let first = batch[chunk.first + id.y].instance * constants.skin_stride;
    let v = skin_vertices[first + i].position;
    var n = vec3<f32>();
    for (var k = one_ring_rows[i]; k < one_ring_rows[i + 1u]; k++) {
        let edge = one_ring_edges[k];
        n += cross(skin_vertices[first + edge.x].position - v,
            skin_vertices[first + edge.y].position - v);
    }
    let length = length(n);
    skin_vertices[first + i].normal = select(vec3(0.0), n / length, length > 1e-20);
}
