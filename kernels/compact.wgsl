// The rows of the active contacts in fixed order (the normal ones vertex by vertex and collider by collider, then
// friction), Jᵀe of each in the reduced space, and for every block of q the rows that move it.

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
@group(0) @binding(10) var<storage, read> vertex_blocks: array<u32>;
@group(0) @binding(11) var<storage, read_write> contacts: array<Contact>;
@group(0) @binding(12) var<storage, read_write> contact_rows: array<vec3<f32>>;
@group(0) @binding(13) var<storage, read_write> block_contacts: array<u32>;
@group(0) @binding(14) var<storage, read> lagged: array<Lagged>;
@group(0) @binding(15) var<storage, read> slips: array<vec4<f32>>;

// One workgroup a state; each thread takes a run of vertex–collider pairs.
@compute @workgroup_size(256)
fn compact(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let state = batch[chunk.first + group.y];
    let first = first_distance(state.slot, 0u, state.colliders);
    let run = run_of(thread, 256u, constants.points * state.colliders);
    var count = 0u;
    for (var pair = run.begin; pair < run.end; pair++) {
        count += u32(distances[first + pair].w > 0.0);
    }
    var at = exclusive_sum(thread, 256u, count);
    if (thread == 255u) {
        let found = at + count;
        let lagged_contacts = min(lagged[lagged_header(state.instance)].vertex, constants.contacts);
        contacts[contact_header(group.y)].vertex = found;
        contacts[contact_header(group.y)].body =
            min(found, constants.contacts) + 2u * lagged_contacts;
    }
    for (var pair = run.begin; pair < run.end; pair++) {
        let d = distances[first + pair];
        if (d.w > 0.0) {
            if (at < constants.contacts) {
                let vertex = pair / state.colliders;
                let index = state.instance * constants.colliders + pair % state.colliders;
                let k = contact_stiffness(colliders[index], points[vertex], state);
                contacts[contact_header(group.y) + 1u + at] =
                    Contact(d.xyz, -(k * d.w), k, vertex, colliders[index].body);
            }
            at++;
        }
    }
}

// Friction's rows behind the normal ones: along the slip f = μ λ f₀′, k = μ λ f₀″, across it k = μ λ f₀′/|u_T|.
// One thread a lagged contact.
@compute @workgroup_size(64)
fn friction_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    let state = batch[chunk.first + id.y];
    let header = lagged_header(state.instance);
    if (id.x >= min(lagged[header].vertex, constants.contacts)) {
        return;
    }
    let contact = lagged[header + 1u + id.x];
    var n = contact.normal;
    if (contact.body > 0u) {
        n = frames[state.slot * constants.bones + contact.body - 1u].rotation * n;
    }
    let slip = slips[state.slot * constants.contacts + id.x].xyz;
    let u = tangential(contact.start + slip, n);
    let y = length(u);
    // At rest every tangent is as good.
    let axis = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(n.x) > 0.5);
    let along = select(normalize(cross(n, axis)), u / y, y > 1e-18);
    let slopes = contact.limit * smoothed_slopes(y, state.smoothing);
    let normal_rows = min(contacts[contact_header(id.y)].vertex, constants.contacts);
    let at = contact_header(id.y) + 1u + normal_rows + 2u * id.x;
    contacts[at] = Contact(along, slopes.x * y, slopes.y, contact.vertex, contact.body);
    contacts[at + 1u] =
        Contact(cross(n, along), 0.0, slopes.x, contact.vertex, contact.body);
}

// Jᵀe of side A, block by block in the vertex's own order: with a = R_j (T − J_j),
//   c_j: w_j e     ω_j: (−w_j [a]×)ᵀ e = w_j a × e     φ_h: U_h Bᵀ e, B = Σ w_j R_j
// and of side B in the last two places: c: −e     ω: −(x − c) × e. One thread a row.
@compute @workgroup_size(64)
fn contact_rows_of(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= contacts[contact_header(id.y)].body) {
        return;
    }
    let state = batch[chunk.first + id.y];
    let contact = contacts[contact_header(id.y) + 1u + id.x];
    let point = points[contact.vertex];
    let rest = unposed[state.instance * constants.points + contact.vertex];
    let t = unposed_position(point, rest, state.slot * constants.handles);
    let row = (id.y * row_room() + id.x) * constants.contact_blocks;
    let n = contact.direction;
    var unposed_normal = vec3<f32>();
    for (var k = 0u; k < point.bones; k++) {
        let w = influences[point.first_influence + k];
        let f = state.slot * constants.bones + w.index;
        contact_rows[row + 2u * k] = w.weight * n;
        contact_rows[row + 2u * k + 1u] =
            w.weight * cross(frames[f].rotation * (t - frames[f].joint), n);
        unposed_normal += w.weight * (n * frames[f].rotation);
    }
    for (var k = 0u; k < point.handles; k++) {
        let u = influences[point.first_influence + point.bones + k];
        contact_rows[row + 2u * point.bones + k] = u.weight * unposed_normal;
    }
    if (contact.body > 0u) {
        let body = frames[state.slot * constants.bones + contact.body - 1u];
        let p = skinned_position(point, t, state.slot * constants.bones);
        let last = row + constants.contact_blocks - 1u;
        contact_rows[last - 1u] = -n;
        contact_rows[last] = -cross(p - body.position, n);
    }
}

// 1 + the place of a block in a row, 0 where it does not move it
fn place_of(block: u32, contact: Contact) -> u32 {
    if (contact.body > 0u && block / 2u == contact.body - 1u) {
        return constants.contact_blocks - 1u + block % 2u;
    }
    let words = (constants.blocks + 3u) / 4u;
    return (vertex_blocks[contact.vertex * words + block / 4u] >> (8u * (block % 4u))) & 255u;
}

// For block b of q: how many rows it moves, then each as row · 256 + its place in it. One workgroup a
// block.
@compute @workgroup_size(64)
fn block_contacts_of(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let rows = contacts[contact_header(group.y)].body;
    let block = group.x;
    let list = (group.y * constants.blocks + block) * (row_room() + 1u);
    let run = run_of(thread, 64u, rows);
    var count = 0u;
    for (var k = run.begin; k < run.end; k++) {
        count += u32(place_of(block, contacts[contact_header(group.y) + 1u + k]) > 0u);
    }
    var at = exclusive_sum(thread, 64u, count);
    if (thread == 63u) {
        block_contacts[list] = at + count;
    }
    for (var k = run.begin; k < run.end; k++) {
        let place = place_of(block, contacts[contact_header(group.y) + 1u + k]);
        if (place > 0u) {
            at++;
            block_contacts[list + at] = k * 256u + place - 1u;
        }
    }
}
