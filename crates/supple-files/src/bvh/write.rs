//! Biovision's motion format out.

use crate::motion::MotionClip;
use glam::{DVec3, EulerRot};
use std::fmt::Write;
use std::path::Path;
use supple::Result;
use supple::internal::write_whole;

/// Writes `clip` as BVH in centimetres, angles in `Zrotation Yrotation Xrotation`. Joints move where the clip
/// says so; unknown rest joints are written as 0.
///
/// # Errors
/// [`supple::Error::Invalid`] of the clip, [`supple::Error::Io`].
pub fn write_bvh(clip: &MotionClip, path: impl AsRef<Path>) -> Result<()> {
    clip.validate()?;
    write_whole(path, bvh_text(clip))
}

/// What [`write_bvh`] writes.
pub fn bvh_text(clip: &MotionClip) -> String {
    let mut children = vec![Vec::new(); clip.bones.len()];
    for (j, parent) in clip.parents.iter().enumerate() {
        if let Some(p) = parent {
            children[*p as usize].push(j);
        }
    }
    let mut out = String::from("HIERARCHY\n");
    let mut order = Vec::new();
    // What is still to be written, last first: joints, and braces to close.
    let roots = (0..clip.bones.len()).filter(|&j| clip.parents[j].is_none());
    let mut open: Vec<(Option<usize>, usize)> = roots.map(|j| (Some(j), 0)).collect();
    open.reverse();
    while let Some((joint, depth)) = open.pop() {
        let indent = "  ".repeat(depth);
        let Some(j) = joint else {
            let _ = writeln!(out, "{indent}}}");
            continue;
        };
        order.push(j);
        let kind = if depth == 0 { "ROOT" } else { "JOINT" };
        let offset = offset(clip, j);
        let places = match clip.translated.contains(&(j as u32)) {
            true => "6 Xposition Yposition Zposition",
            false => "3",
        };
        let _ = writeln!(out, "{indent}{kind} {}\n{indent}{{", clip.bones[j]);
        let _ = writeln!(out, "{indent}  OFFSET {}", numbers(offset));
        let _ = writeln!(
            out,
            "{indent}  CHANNELS {places} Zrotation Yrotation Xrotation"
        );
        if children[j].is_empty() {
            let _ = writeln!(
                out,
                "{indent}  End Site\n{indent}  {{\n{indent}    OFFSET 0 0 0\n{indent}  }}"
            );
        }
        open.push((None, depth));
        open.extend(children[j].iter().rev().map(|&c| (Some(c), depth + 1)));
    }
    let _ = writeln!(out, "MOTION\nFrames: {}", clip.frames.len());
    let _ = writeln!(out, "Frame Time: {:.6}", clip.frame_time);
    for frame in &clip.frames {
        let mut row = Vec::new();
        for &j in &order {
            if let Ok(k) = clip.translated.binary_search(&(j as u32)) {
                row.push(numbers(offset(clip, j) + 100.0 * frame.translations[k]));
            }
            let (z, y, x) = frame.rotations[j].to_euler(EulerRot::ZYX);
            row.push(numbers(DVec3::new(z, y, x) * 180.0 / std::f64::consts::PI));
        }
        out.push_str(&row.join(" "));
        out.push('\n');
    }
    out
}

/// From its parent's joint, cm.
fn offset(clip: &MotionClip, j: usize) -> DVec3 {
    let rest = |j: usize| clip.rest_joints.as_ref().map_or(DVec3::ZERO, |r| r[j]);
    let parent = clip.parents[j].map_or(DVec3::ZERO, |p| rest(p as usize));
    100.0 * (rest(j) - parent)
}

/// Three numbers to four places, without a negative zero.
fn numbers(v: DVec3) -> String {
    let number = |x: f64| {
        let text = format!("{x:.4}");
        if text == "-0.0000" {
            "0.0000".into()
        } else {
            text
        }
    };
    v.to_array().map(number).join(" ")
}
