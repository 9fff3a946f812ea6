// Signed distance of every skin vertex from every collider, both relative to the instance's origin; a
// vertex touches nothing that a frame of its own carries:
//   p = Σ_j w_j ( R_j (T − J_j) + c_j ),  δ = d̂ − d(p);  E = ½ k a δ² where δ > 0
// One thread a vertex.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read> frames: array<Frame>;
@group(0) @binding(6) var<storage, read> handles: array<Handle>;
@group(0) @binding(7) var<storage, read> unposed: array<vec3<f32>>;
@group(0) @binding(8) var<storage, read> colliders: array<Collider>;
@group(0) @binding(9) var<storage, read_write> distances: array<vec4<f32>>;

// Whether `bone` is among a point's bones.
fn moves_with(point: Point, bone: u32) -> bool {
    var found = false;
    for (var k = 0u; k < point.bones; k++) {
        found |= influences[point.first_influence + k].index == bone;
    }
    return found;
}

@compute @workgroup_size(64)
fn contact(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= constants.points) {
        return;
    }
    let state = batch[chunk.first + id.y];
    let point = points[i];
    let first = first_distance(state.slot, i, state.colliders);
    // A vertex without an area touches nothing.
    if (point.measure == 0.0) {
        for (var k = 0u; k < state.colliders; k++) {
            distances[first + k] = vec4(0.0);
        }
        return;
    }
    let rest = unposed[state.instance * constants.points + i];
    let t = unposed_position(point, rest, state.slot * constants.handles);
    let p = skinned_position(point, t, state.slot * constants.bones);
    for (var k = 0u; k < state.colliders; k++) {
        let collider = colliders[state.instance * constants.colliders + k];
        var rotation = collider.rotation;
        var position = collider.position;
        if (collider.body > 0u) {
            if (moves_with(point, collider.body - 1u)) {
                distances[first + k] = vec4(0.0);
                continue;
            }
            let body = frames[state.slot * constants.bones + collider.body - 1u];
            rotation = body.rotation * collider.rotation;
            position = body.rotation * collider.position + body.position;
        }
        // The collider's own frame: Rᵀ (p − c).
        let d = signed_distance(collider.shape, collider.parameters, (p - position) * rotation);
        var depth = collider.margin - d.distance;
        // What was left out at the step's start stays out.
        if (!is_start(state.slot, state.instance)) {
            let start = distances[first_distance(state.instance, i, state.colliders) + k].w;
            if (is_left_out(start)) {
                depth = left_out(depth);
            }
        }
        distances[first + k] = vec4(rotation * d.normal, depth);
    }
}
