// Where more pairs of a skin vertex and a collider may touch than there is room for, the deepest at a step's start are
// kept, the same through all evaluations of the step, so that E stays one function: the δ of every other pair at qⁿ
// becomes a mark that no distance has, and kernel `contact` leaves out what is marked there.
//
// The least key that is kept is found byte by byte, from the highest: a histogram of the keys that share the bytes found
// so far, and in it the byte at which the room ends. Pairs that are equally deep there are all left out.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read_write> distances: array<vec4<f32>>;

var<workgroup> histogram: array<atomic<u32>, 256>;
// The byte at which the room ends, the room that deeper ones leave, and whether it ends at all.
var<workgroup> found: vec3<u32>;

// Rises with δ; 0 of a pair that cannot touch, which takes no room.
fn depth_key(d: vec4<f32>) -> u32 {
    let bits = bitcast<u32>(d.w);
    let rising = select(bits | 0x80000000u, ~bits, bits >> 31u == 1u);
    return select(rising, 0u, all(d == vec4(0.0)));
}

// One workgroup a state; each thread takes a run of pairs.
@compute @workgroup_size(256)
fn keep_deepest(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let state = batch[chunk.first + group.y];
    let first = first_distance(state.slot, 0u, state.colliders);
    let run = run_of(thread, 256u, constants.points * state.colliders);
    var prefix = 0u;
    var mask = 0u;
    var room = constants.contacts;
    var ends = true;
    for (var byte = 0u; byte < 4u; byte++) {
        let shift = 24u - 8u * byte;
        atomicStore(&histogram[thread], 0u);
        workgroupBarrier();
        for (var pair = run.begin; pair < run.end; pair++) {
            let key = depth_key(distances[first + pair]);
            if (key > 0u && (key & mask) == prefix) {
                atomicAdd(&histogram[(key >> shift) & 255u], 1u);
            }
        }
        workgroupBarrier();
        if (thread == 0u) {
            var left = room;
            var value = 256u;
            var count = 0u;
            while (value > 0u && count <= left) {
                left -= count;
                value--;
                count = atomicLoad(&histogram[value]);
            }
            found = vec3(value, left, u32(count > left));
        }
        let here = workgroupUniformLoad(&found);
        ends = ends && here.z == 1u;
        prefix |= here.x << shift;
        mask |= 255u << shift;
        room = here.y;
    }
    if (!ends) {
        return;
    }
    for (var pair = run.begin; pair < run.end; pair++) {
        let d = distances[first + pair];
        let key = depth_key(d);
        if (key > 0u && key <= prefix) {
            distances[first + pair].w = left_out(d.w);
        }
    }
}
