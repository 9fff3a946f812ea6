// A workgroup lists items in order: each thread takes a run of them and counts what belongs on the list; the
// exclusive sum of the counts is where its part of the list begins.

struct Run {
    begin: u32,
    end: u32,
}

// The run of `items` that a thread of `width` takes.
fn run_of(thread: u32, width: u32, items: u32) -> Run {
    let length = (items + width - 1u) / width;
    return Run(min(thread * length, items), min((thread + 1u) * length, items));
}

var<workgroup> counts: array<u32, 256>;

// The sum of the counts of lower threads; `counts` ends as the inclusive sums.
fn exclusive_sum(thread: u32, width: u32, count: u32) -> u32 {
    counts[thread] = count;
    workgroupBarrier();
    for (var step = 1u; step < width; step *= 2u) {
        var sum = counts[thread];
        if (thread >= step) {
            sum += counts[thread - step];
        }
        workgroupBarrier();
        counts[thread] = sum;
        workgroupBarrier();
    }
    return counts[thread] - count;
}
