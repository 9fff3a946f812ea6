// A workgroup lists items in order: each lane takes a run of them and counts what belongs on the list; the
// exclusive sum of the counts is where its part of the list begins.

struct Run {
    begin: u32,
    end: u32,
}

// The run of `items` that a lane of `width` takes.
fn run_of(lane: u32, width: u32, items: u32) -> Run {
    let length = (items + width - 1u) / width;
    return Run(min(lane * length, items), min((lane + 1u) * length, items));
}

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
