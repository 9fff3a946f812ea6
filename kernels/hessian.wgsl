// The packed lower blocks of the solver's Hessian: Σ of the points' blocks in fixed order, and
// Σ k (J_aᵀ e)(J_bᵀ e)ᵀ over the contacts' rows that move both blocks. Blocks of prescribed frames are zero. One thread a
// segment of a block's points; the first of a block's segments sums them up.

struct HessianSegment {
    block: u32,  // among the stored ones
    row: u32,
    column: u32,
    first: u32,  // its entries in gather_pairs
    end: u32,
    count: u32,  // segments of its block from here on, 0 of all but the first
}

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> hessian_segments: array<HessianSegment>;
@group(0) @binding(3) var<storage, read> gather_pairs: array<u32>;  // 2 · pair + transposed
@group(0) @binding(4) var<storage, read> point_hessians: array<mat3x3<f32>>;
@group(0) @binding(5) var<storage, read> contacts: array<Contact>;
@group(0) @binding(6) var<storage, read> contact_rows: array<vec3<f32>>;
@group(0) @binding(7) var<storage, read> block_contacts: array<u32>;
@group(0) @binding(8) var<storage, read_write> result: array<f32>;
@group(0) @binding(9) var<storage, read> prescribed: array<u32>;  // a bit for each bone of a state

// Whether a block is a prescribed frame's.
fn is_prescribed(block: u32, state: u32) -> bool {
    if (block >= 2u * constants.bones) {
        return false;
    }
    let words = (constants.bones + 31u) / 32u;
    let bone = block / 2u;
    return ((prescribed[state * words + bone / 32u] >> (bone % 32u)) & 1u) == 1u;
}

// Σ over the terms of a segment.
fn sum_of_points(segment: HessianSegment, batch_row: u32) -> mat3x3<f32> {
    var sum = mat3x3<f32>();
    let first = batch_row * constants.local_pairs;
    for (var k = segment.first; k < segment.end; k++) {
        let entry = gather_pairs[k];
        let h = point_hessians[first + entry / 2u];
        if (entry % 2u == 1u) {
            sum += transpose(h);
        } else {
            sum += h;
        }
    }
    return sum;
}

// Σ over the contacts' rows that move both blocks.
fn sum_of_contacts(row_block: u32, column_block: u32, batch_row: u32) -> mat3x3<f32> {
    var sum = mat3x3<f32>();
    // Both blocks' lists of contacts rise: meet where they agree.
    let stride = row_room() + 1u;
    let row_list = (batch_row * constants.blocks + row_block) * stride;
    let column_list = (batch_row * constants.blocks + column_block) * stride;
    let row_end = row_list + block_contacts[row_list];
    let column_end = column_list + block_contacts[column_list];
    var r = row_list + 1u;
    var c = column_list + 1u;
    while (r <= row_end && c <= column_end) {
        let here = block_contacts[r];
        let there = block_contacts[c];
        let contact = here / 256u;
        if (contact == there / 256u) {
            let rows = (batch_row * row_room() + contact) * constants.contact_blocks;
            let row = contact_rows[rows + here % 256u];
            let column = contacts[contact_header(batch_row) + 1u + contact].stiffness
                * contact_rows[rows + there % 256u];
            sum += mat3x3<f32>(row * column.x, row * column.y, row * column.z);
        }
        r += u32(contact <= there / 256u);
        c += u32(contact >= there / 256u);
    }
    return sum;
}

var<workgroup> sums: array<mat3x3<f32>, 64>;

@compute @workgroup_size(64)
fn hessian(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let segment = hessian_segments[64u * group.x + thread];
    let state = chunk.first + group.y;
    let left_out = is_prescribed(segment.row, state) || is_prescribed(segment.column, state);
    var sum = mat3x3<f32>();
    if (!left_out) {
        sum = sum_of_points(segment, group.y);
    }
    sums[thread] = sum;
    workgroupBarrier();
    if (segment.count == 0u) {
        return;
    }
    for (var k = 1u; k < segment.count; k++) {
        sum += sums[thread + k];
    }
    if (!left_out) {
        sum += sum_of_contacts(segment.row, segment.column, group.y);
    }
    let numbers = 3u * constants.blocks + 9u * constants.pattern_blocks;
    let out = state * numbers + 3u * constants.blocks + 9u * segment.block;
    for (var column = 0u; column < 3u; column++) {
        result[out + 3u * column] = sum[column].x;
        result[out + 3u * column + 1u] = sum[column].y;
        result[out + 3u * column + 2u] = sum[column].z;
    }
}
