// Active contacts in fixed order (vertex by vertex, collider by collider), the row Jᵀn that each has
// in the reduced space, and for every block of q the contacts that move it.

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

var<workgroup> counts: array<u32, 256>;

// The sum of the counts of lower lanes; `counts` ends as the inclusive sums.
fn exclusive_sum(lane: u32, width: u32, count: u32) -> u32 {
    counts[lane] = count;
    workgroupBarrier();
    for (var step = 1u; step < width; step *= 2u) {
        var sum = counts[lane];
        if (lane >= step) {
            sum += counts[lane - step];
        }
        workgroupBarrier();
        counts[lane] = sum;
        workgroupBarrier();
    }
    return counts[lane] - count;
}

// One workgroup a state; each thread takes a run of vertex–collider pairs.
@compute @workgroup_size(256)
fn compact(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let state = batch[chunk.first + group.y];
    let first = first_distance(state.slot, 0u, state.colliders);
    let pairs = constants.points * state.colliders;
    let run = (pairs + 255u) / 256u;
    let begin = min(lane * run, pairs);
    let end = min(begin + run, pairs);
    var count = 0u;
    for (var pair = begin; pair < end; pair++) {
        count += u32(distances[first + pair].w > 0.0);
    }
    var at = exclusive_sum(lane, 256u, count);
    if (lane == 255u) {
        contacts[contact_header(group.y)].vertex = at + count;
    }
    for (var pair = begin; pair < end; pair++) {
        let d = distances[first + pair];
        if (d.w > 0.0) {
            if (at < constants.contacts) {
                let vertex = pair / state.colliders;
                let collider = pair % state.colliders;
                let k = colliders[state.instance * constants.colliders + collider].stiffness;
                contacts[contact_header(group.y) + 1u + at] =
                    Contact(d.xyz, d.w, k * points[vertex].measure, vertex, collider);
            }
            at++;
        }
    }
}

// Jᵀn of side A, block by block in the vertex's own order: with a = R_j (T − J_j),
//   c_j: w_j n     ω_j: (−w_j [a]×)ᵀ n = w_j a × n     φ_h: U_h Bᵀ n, B = Σ w_j R_j
// One thread a contact.
@compute @workgroup_size(64)
fn contact_rows_of(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= min(contacts[contact_header(id.y)].vertex, constants.contacts)) {
        return;
    }
    let state = batch[chunk.first + id.y];
    let contact = contacts[contact_header(id.y) + 1u + id.x];
    let point = points[contact.vertex];
    let rest = unposed[state.instance * constants.points + contact.vertex];
    let t = unposed_position(point, rest, state.slot * constants.handles);
    let row = (id.y * constants.contacts + id.x) * constants.contact_blocks;
    let n = contact.normal;
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
}

// 1 + the place of a block in the vertex's own order, 0 where it does not move it
fn place_of(block: u32, vertex: u32) -> u32 {
    let words = (constants.blocks + 3u) / 4u;
    return (vertex_blocks[vertex * words + block / 4u] >> (8u * (block % 4u))) & 255u;
}

// For block b of q: how many contacts move it, then each as contact · 256 + its place in the
// vertex's own order. One workgroup a block.
@compute @workgroup_size(64)
fn block_contacts_of(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let active_contacts = min(contacts[contact_header(group.y)].vertex, constants.contacts);
    let block = group.x;
    let list = (group.y * constants.blocks + block) * (constants.contacts + 1u);
    let run = (active_contacts + 63u) / 64u;
    let begin = min(lane * run, active_contacts);
    let end = min(begin + run, active_contacts);
    var count = 0u;
    for (var k = begin; k < end; k++) {
        count += u32(place_of(block, contacts[contact_header(group.y) + 1u + k].vertex) > 0u);
    }
    var at = exclusive_sum(lane, 64u, count);
    if (lane == 63u) {
        block_contacts[list] = at + count;
    }
    for (var k = begin; k < end; k++) {
        let place = place_of(block, contacts[contact_header(group.y) + 1u + k].vertex);
        if (place > 0u) {
            at++;
            block_contacts[list + at] = k * 256u + place - 1u;
        }
    }
}
