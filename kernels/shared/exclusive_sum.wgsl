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
