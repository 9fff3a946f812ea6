// The packed lower blocks of the solver's Hessian: Σ of the points' blocks in fixed order, and
// Σ k (J_aᵀ e)(J_bᵀ e)ᵀ over the contacts' rows that move both blocks. One thread a block.

struct PatternBlock {
    row: u32,
    column: u32,
    first: u32,  // its entries in gather_pairs
    end: u32,
}

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> pattern: array<PatternBlock>;
@group(0) @binding(3) var<storage, read> gather_pairs: array<u32>;  // 2 · pair + transposed
@group(0) @binding(4) var<storage, read> point_hessians: array<mat3x3<f32>>;
@group(0) @binding(5) var<storage, read> contacts: array<Contact>;
@group(0) @binding(6) var<storage, read> contact_rows: array<vec3<f32>>;
@group(0) @binding(7) var<storage, read> block_contacts: array<u32>;
@group(0) @binding(8) var<storage, read_write> result: array<f32>;

@compute @workgroup_size(64)
fn hessian(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.x;
    if (at >= constants.pattern_blocks) {
        return;
    }
    let block = pattern[at];

    var sum = mat3x3<f32>();
    let first = id.y * constants.local_pairs;
    for (var k = block.first; k < block.end; k++) {
        let entry = gather_pairs[k];
        let h = point_hessians[first + entry / 2u];
        if (entry % 2u == 1u) {
            sum += transpose(h);
        } else {
            sum += h;
        }
    }

    // Both blocks' lists of contacts rise: meet where they agree.
    let stride = row_room() + 1u;
    let row_list = (id.y * constants.blocks + block.row) * stride;
    let column_list = (id.y * constants.blocks + block.column) * stride;
    let row_end = row_list + block_contacts[row_list];
    let column_end = column_list + block_contacts[column_list];
    var r = row_list + 1u;
    var c = column_list + 1u;
    while (r <= row_end && c <= column_end) {
        let here = block_contacts[r];
        let there = block_contacts[c];
        let contact = here / 256u;
        if (contact == there / 256u) {
            let rows = (id.y * row_room() + contact) * constants.contact_blocks;
            let row = contact_rows[rows + here % 256u];
            let column = contacts[contact_header(id.y) + 1u + contact].stiffness
                * contact_rows[rows + there % 256u];
            sum += mat3x3<f32>(row * column.x, row * column.y, row * column.z);
        }
        r += u32(contact <= there / 256u);
        c += u32(contact >= there / 256u);
    }

    let numbers = 3u * constants.blocks + 9u * constants.pattern_blocks;
    let out = (chunk.first + id.y) * numbers + 3u * constants.blocks + 9u * at;
    for (var column = 0u; column < 3u; column++) {
        result[out + 3u * column] = sum[column].x;
        result[out + 3u * column + 1u] = sum[column].y;
        result[out + 3u * column + 2u] = sum[column].z;
    }
}
