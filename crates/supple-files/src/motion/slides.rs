//! Joints of a clip that slide against their parents.

use super::motion_clip::MotionClip;
use glam::DVec3;

/// Way that is worth a word, m.
const LEAST: f64 = 2e-3;
/// Most joints that are named.
const MOST: usize = 5;

/// A word about joints of `clip` that slide: an avatar's joints are closed, so its bones turn as the clip's do, but do
/// not follow. `followed` are the bones whose places count. `from_rest`: how far they are from their rest places,
/// else from the first frame's.
pub(super) fn slides(clip: &MotionClip, followed: &[bool], from_rest: bool) -> Option<String> {
    let first = &clip.frames.first()?.translations;
    let way = |k: usize| {
        let start = if from_rest { DVec3::ZERO } else { first[k] };
        let ways = clip
            .frames
            .iter()
            .map(|f| (f.translations[k] - start).length());
        ways.fold(0.0, f64::max)
    };
    let mut found: Vec<(f64, &str)> = (clip.translated.iter().enumerate())
        .filter(|(_, bone)| !followed[**bone as usize])
        .map(|(k, bone)| (way(k), clip.bones[*bone as usize].as_str()))
        .filter(|(way, _)| *way > LEAST)
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let named: Vec<String> = (found.iter().take(MOST))
        .map(|(way, bone)| format!("{bone} by {:.0} mm", 1e3 * way))
        .collect();
    let more = match found.len().saturating_sub(MOST) {
        0 => String::new(),
        n => format!(" and {n} others"),
    };
    (!named.is_empty()).then(|| {
        format!(
            "clip {:?} slides joints against their parents, which closed joints do not follow: {}{more}",
            clip.name,
            named.join(", ")
        )
    })
}
