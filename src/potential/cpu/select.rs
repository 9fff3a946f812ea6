//! Which pairs of vertex and collider a list with limited room keeps: the twin of the kernel. The f64 evaluation has room
//! for all.

/// The pairs that are kept of those with these δ, m; none of a pair that cannot touch. At most `room`: the deepest, and
/// of those that are equally deep where the room ends, none.
pub fn keep_deepest(depths: &[Option<f32>], room: usize) -> Vec<bool> {
    let mut sorted: Vec<f32> = depths.iter().flatten().copied().collect();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let ends = sorted.get(room).copied();
    let kept = |depth: &Option<f32>| match (depth, ends) {
        (Some(depth), Some(end)) => depth.total_cmp(&end).is_gt(),
        _ => true,
    };
    depths.iter().map(kept).collect()
}
