// Friction's own records: the contacts of a step's start that have friction, and the slip of each since,
//   u = d − (ΔR a + Δc),
// d the vertex's displacement since qⁿ and (ΔR, Δc) that of the frame that the collider is fixed to,
// both from increments.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read> frames: array<Frame>;
@group(0) @binding(6) var<storage, read> handles: array<Handle>;
@group(0) @binding(7) var<storage, read> unposed: array<vec3<f32>>;
@group(0) @binding(8) var<storage, read> colliders: array<Collider>;
@group(0) @binding(9) var<storage, read> distances: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read_write> lagged: array<Lagged>;
@group(0) @binding(11) var<storage, read_write> slips: array<vec4<f32>>;

// Whether a vertex and a collider, one pair of `distances`, touch and have friction.
fn has_friction(pair: u32, collider: u32) -> bool {
    return colliders[collider].friction > 0.0 && distances[pair].w > 0.0;
}

// Lists what touches a rough collider at qⁿ, with λ = k a δ |∇d| and n along ∇d in world axes; where ∇d
// vanishes (between samples of a distance) nothing has_friction. `distances` and `colliders` are those of tⁿ. One
// workgroup a state; each thread takes a run of vertex–collider pairs.
@compute @workgroup_size(256)
fn lag(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let state = batch[chunk.first + group.y];
    let first = first_distance(state.slot, 0u, state.colliders);
    let first_collider = state.instance * constants.colliders;
    let run = run_of(thread, 256u, constants.points * state.colliders);
    var count = 0u;
    for (var pair = run.begin; pair < run.end; pair++) {
        count += u32(has_friction(first + pair, first_collider + pair % state.colliders));
    }
    var at = exclusive_sum(thread, 256u, count);
    let header = lagged_header(state.instance);
    if (thread == 255u) {
        lagged[header].vertex = at + count;
    }
    for (var pair = run.begin; pair < run.end; pair++) {
        let index = pair % state.colliders;
        if (has_friction(first + pair, first_collider + index)) {
            if (at < constants.contacts) {
                let vertex = pair / state.colliders;
                lagged[header + 1u + at] = started(
                    distances[first + pair], vertex, index, colliders[first_collider + index], state);
            }
            at++;
        }
    }
}

// A contact (∇d, δ) of qⁿ, without what `anchor` adds.
fn started(d: vec4<f32>, vertex: u32, index: u32, collider: Collider, state: BatchState) -> Lagged {
    var slope = length(d.xyz);
    var n = vec3(0.0, 0.0, 1.0);
    if (slope > 1e-18) {
        n = d.xyz / slope;
    } else {
        slope = 0.0;
    }
    let force = contact_stiffness(collider, points[vertex], state) * d.w * slope;
    return Lagged(vec3(0.0), collider.friction * force, n, vertex, vec3(0.0), collider.body, index);
}

// Into the frame that the collider is fixed to: a, n and u at qⁿ. One thread a lagged contact.
@compute @workgroup_size(64)
fn anchor(@builtin(global_invocation_id) id: vec3<u32>) {
    let state = batch[chunk.first + id.y];
    let header = lagged_header(state.instance);
    if (id.x >= min(lagged[header].vertex, constants.contacts)) {
        return;
    }
    let at = header + 1u + id.x;
    let contact = lagged[at];
    let point = points[contact.vertex];
    let rest = unposed[state.instance * constants.points + contact.vertex];
    let t = unposed_position(point, rest, state.slot * constants.handles);
    let p = skinned_position(point, t, state.slot * constants.bones);
    if (contact.body > 0u) {
        let body = frames[state.slot * constants.bones + contact.body - 1u];
        lagged[at].anchor = (p - body.position) * body.rotation;
        lagged[at].normal = contact.normal * body.rotation;
        return;
    }
    let collider = colliders[state.instance * constants.colliders + contact.collider];
    let a = (p - collider.position) * collider.rotation;
    let n = contact.normal * collider.rotation;
    lagged[at].anchor = a;
    lagged[at].normal = collider.rotation * n + collider.rotation_change * n;
    lagged[at].start = -(collider.rotation_change * a + collider.position_change);
}

// What a state's increments from its base add to u. One thread a lagged contact.
@compute @workgroup_size(64)
fn slip(@builtin(global_invocation_id) id: vec3<u32>) {
    let state = batch[chunk.first + id.y];
    let header = lagged_header(state.instance);
    if (id.x >= min(lagged[header].vertex, constants.contacts)) {
        return;
    }
    let contact = lagged[header + 1u + id.x];
    let rest = unposed[state.instance * constants.points + contact.vertex];
    let moved = motion_since_base(points[contact.vertex], rest,
        state.slot * constants.handles, state.slot * constants.bones);
    var u = moved.displacement;
    if (contact.body > 0u) {
        let f = state.slot * constants.bones + contact.body - 1u;
        u -= frames[f].rotation_increment * contact.anchor + frames[f].position_increment;
    }
    slips[state.slot * constants.contacts + id.x] = vec4(u, 0.0);
}
