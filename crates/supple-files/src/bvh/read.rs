//! Biovision's motion format, BVH.
//!
//! Meredith and Maddock, *Motion Capture File Formats Explained*, 2001. Channels turn in the order in
//! which they are listed: `Zrotation Yrotation Xrotation` is R = R_z R_y R_x. A position channel says where
//! its joint is in its parent's axes: it takes the place of that coordinate of OFFSET, as in the programs
//! that write such channels on inner joints.

use crate::file;
use crate::motion::figure::is_figure;
use crate::motion::{MotionClip, MotionFrame, Unit};
use glam::{DQuat, DVec3};
use std::collections::HashSet;
use std::path::Path;
use supple::model::UpAxis;
use supple::{Error, Result};

/// What a BVH file does not say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BvhOptions {
    /// The unit of its lengths; centimetres if not given.
    pub unit: Option<Unit>,
    /// The axis that points up; if not given y, or z where the skeleton is higher along z than along y.
    pub up: Option<UpAxis>,
}

/// Reads the BVH file at `path`.
///
/// # Errors
/// [`Error::Io`]; [`Error::Format`] with the line where it is broken.
pub fn read_bvh(path: impl AsRef<Path>, options: &BvhOptions) -> Result<MotionClip> {
    let path = path.as_ref();
    let bytes = file::read_bytes(path)?;
    parse_bvh(&String::from_utf8_lossy(&bytes), path, options)
}

/// Reads BVH from `text`; `path` names it in errors. See [`read_bvh`].
pub fn parse_bvh(text: &str, path: &Path, options: &BvhOptions) -> Result<MotionClip> {
    let unit = options.unit.as_ref().map_or(Ok(0.01), Unit::metres)?;
    let mut lines = Lines::new(text, path);
    let skeleton = Hierarchy::parse(&mut lines)?;
    let Rows {
        frame_time,
        numbers,
        notes,
    } = Rows::parse(&mut lines, skeleton.channels)?;
    let translated: Vec<u32> = (skeleton.joints.iter().zip(0..))
        .filter(|(joint, _)| joint.channels.iter().any(|c| !c.turns))
        .map(|(_, j)| j)
        .collect();
    let joints = &skeleton.joints;
    let mut rest_joints: Vec<DVec3> = Vec::with_capacity(joints.len());
    for joint in joints {
        let parent = joint
            .parent
            .map_or(DVec3::ZERO, |p| rest_joints[p as usize]);
        rest_joints.push(parent + unit * joint.offset);
    }
    let mut clip = MotionClip {
        name: path
            .file_stem()
            .map_or_else(|| "motion".into(), |s| s.to_string_lossy().into_owned()),
        bones: joints.iter().map(|j| j.name.clone()).collect(),
        parents: joints.iter().map(|j| j.parent).collect(),
        rest_joints: Some(rest_joints),
        frame_time,
        frames: (numbers.chunks_exact(skeleton.channels.max(1)))
            .map(|row| frame(joints, &translated, row, unit))
            .collect(),
        translated,
        notes,
        ..MotionClip::default()
    };
    let up = options.up.unwrap_or_else(|| higher_axis(&clip));
    (clip.rest_up, clip.world_up) = (up, up);
    clip.validate().map_err(|e| e.of_file(path))?;
    Ok(clip)
}

/// A pose from a line of numbers.
fn frame(joints: &[Joint], translated: &[u32], row: &[f64], unit: f64) -> MotionFrame {
    let mut values = row.iter();
    let mut frame = MotionFrame::default();
    for (joint, j) in joints.iter().zip(0..) {
        let (mut place, mut rotation) = (joint.offset, DQuat::IDENTITY);
        for (channel, value) in joint.channels.iter().zip(&mut values) {
            if channel.turns {
                let axis = [DVec3::X, DVec3::Y, DVec3::Z][channel.axis];
                rotation *= DQuat::from_axis_angle(axis, value.to_radians());
            } else {
                place[channel.axis] = *value;
            }
        }
        frame.rotations.push(rotation.normalize());
        if translated.binary_search(&j).is_ok() {
            frame.translations.push(unit * (place - joint.offset));
        }
    }
    frame
}

/// y, or z where the joints reach half as far again along it. Arms held out do not count: they go along x. Where the
/// zero pose is no figure, it is the poses that reach.
fn higher_axis(clip: &MotionClip) -> UpAxis {
    let extent = |joints: &[DVec3]| {
        let low = joints.iter().fold(DVec3::INFINITY, |a, b| a.min(*b));
        let high = joints.iter().fold(DVec3::NEG_INFINITY, |a, b| a.max(*b));
        high - low
    };
    let posed = |frame: &MotionFrame| {
        let joints = clip.world_frames(frame).into_iter().map(|f| f.position);
        extent(&joints.collect::<Vec<_>>())
    };
    let extent = match &clip.rest_joints {
        Some(rest) if is_figure(&clip.bones, rest) => extent(rest),
        _ => clip.spread_frames().map(posed).sum(),
    };
    if extent.z > 1.5 * extent.y {
        UpAxis::Z
    } else {
        UpAxis::Y
    }
}

/// One number of a frame's line.
#[derive(Clone, Copy)]
struct Channel {
    axis: usize,
    turns: bool,
}

struct Joint {
    name: String,
    parent: Option<u32>,
    offset: DVec3,
    channels: Vec<Channel>,
}

struct Hierarchy {
    joints: Vec<Joint>,
    /// Numbers in a frame's line.
    channels: usize,
}

/// What a brace closes.
enum Open {
    Joint(u32),
    EndSite,
}

impl Hierarchy {
    /// From HIERARCHY to MOTION.
    fn parse(lines: &mut Lines<'_>) -> Result<Self> {
        let mut this = Self {
            joints: Vec::new(),
            channels: 0,
        };
        let mut names = HashSet::new();
        let (mut open, mut next): (Vec<Open>, Option<Open>) = (Vec::new(), None);
        match lines.next() {
            Some(line) if line.trim().eq_ignore_ascii_case("HIERARCHY") => {}
            _ => return Err(lines.broken("a BVH file begins with HIERARCHY")),
        }
        while let Some(line) = lines.next() {
            let mut words = line.split_whitespace().peekable();
            while let Some(word) = words.next() {
                match word.to_ascii_uppercase().as_str() {
                    "ROOT" | "JOINT" => {
                        let mut name = Vec::new();
                        while let Some(word) = words.next_if(|w| *w != "{") {
                            name.push(word);
                        }
                        next = Some(Open::Joint(this.joints.len() as u32));
                        let parent = match open.last() {
                            Some(Open::Joint(j)) => Some(*j),
                            Some(Open::EndSite) => {
                                return Err(lines.broken("an End Site has no joints"));
                            }
                            None => None,
                        };
                        this.joints.push(Joint {
                            name: unique(name.join(" "), &mut names),
                            parent,
                            offset: DVec3::ZERO,
                            channels: Vec::new(),
                        });
                    }
                    "END" => {
                        words.next_if(|w| w.eq_ignore_ascii_case("Site"));
                        next = Some(Open::EndSite);
                    }
                    "{" => {
                        let opened = next.take();
                        open.push(opened.ok_or_else(|| lines.broken("{ follows a joint's name"))?);
                    }
                    "}" => {
                        open.pop().ok_or_else(|| lines.broken("} closes nothing"))?;
                    }
                    "OFFSET" => {
                        let mut number = || lines.number(words.next().unwrap_or(""));
                        let offset = DVec3::new(number()?, number()?, number()?);
                        match open.last() {
                            Some(Open::Joint(j)) => this.joints[*j as usize].offset = offset,
                            Some(Open::EndSite) => {}
                            None => return Err(lines.broken("OFFSET stands outside a joint")),
                        }
                    }
                    "CHANNELS" => {
                        let Some(Open::Joint(j)) = open.last() else {
                            return Err(lines.broken("CHANNELS stand outside a joint"));
                        };
                        let count = lines.number(words.next().unwrap_or(""))?;
                        let channels = words.by_ref().map(|w| lines.channel(w));
                        let channels: Vec<Channel> = channels.collect::<Result<_>>()?;
                        if channels.len() as f64 != count {
                            let problem =
                                format!("{count} channels announced, {} named", channels.len());
                            return Err(lines.broken(problem));
                        }
                        this.channels += channels.len();
                        this.joints[*j as usize].channels = channels;
                    }
                    "MOTION" if open.is_empty() && !this.joints.is_empty() => return Ok(this),
                    "MOTION" => return Err(lines.broken("MOTION comes before every { is closed")),
                    _ => {
                        let problem =
                            format!("{word:?} is none of JOINT, OFFSET, CHANNELS, End Site");
                        return Err(lines.broken(problem));
                    }
                }
            }
        }
        Err(lines.broken("ends before MOTION"))
    }
}

/// Some exporters repeat names: `Thumb`, `Thumb#2`.
fn unique(name: String, taken: &mut HashSet<String>) -> String {
    let mut candidate = name.clone();
    let mut count = 1;
    while !taken.insert(candidate.clone()) {
        count += 1;
        candidate = format!("{name}#{count}");
    }
    candidate
}

/// What stands from `Frames:` on.
struct Rows {
    /// s.
    frame_time: f64,
    /// Those of whole frames, one after the other.
    numbers: Vec<f64>,
    notes: Vec<String>,
}

impl Rows {
    /// The frames that are there count, whatever is announced: some exporters count one too few or too many, and
    /// who cuts a clip seldom mends `Frames:`. A torn frame says that the file was cut by accident.
    fn parse(lines: &mut Lines<'_>, channels: usize) -> Result<Self> {
        let announced = lines.entry("Frames")?;
        if announced < 0.0 || announced.fract() != 0.0 {
            return Err(lines.broken("Frames must be a whole number"));
        }
        let frame_time = lines.entry("Frame Time")?;
        if frame_time <= 0.0 {
            return Err(lines.broken("Frame Time must be positive (s)"));
        }
        let mut numbers = Vec::new();
        while let Some(line) = lines.next() {
            for word in line.split_whitespace() {
                numbers.push(lines.number(word)?);
            }
        }
        let (Some(frames), Some(left)) = (
            numbers.len().checked_div(channels),
            numbers.len().checked_rem(channels),
        ) else {
            return Err(lines.broken("no joint has channels: nothing moves"));
        };
        if frames == 0 || left > 0 {
            let problem = format!(
                "{announced} frames of {channels} numbers are announced, {} numbers are there: {frames} frames and \
                 {left} numbers of another; take out the torn line",
                numbers.len()
            );
            return Err(lines.broken(problem));
        }
        let notes = (frames as f64 != announced)
            .then(|| format!("Frames: announces {announced} frames, {frames} are there and read"));
        Ok(Self {
            frame_time,
            numbers,
            notes: notes.into_iter().collect(),
        })
    }
}

/// The lines that are not empty, and the number of the last one taken.
struct Lines<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    path: &'a Path,
    number: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str, path: &'a Path) -> Self {
        let text = text.trim_start_matches('\u{feff}');
        Self {
            lines: text.lines().enumerate(),
            path,
            number: 0,
        }
    }

    fn next(&mut self) -> Option<&'a str> {
        let (number, line) = self.lines.find(|(_, line)| !line.trim().is_empty())?;
        self.number = number + 1;
        Some(line)
    }

    fn broken(&self, problem: impl Into<String>) -> Error {
        Error::format(self.path, format!("line {}", self.number), problem)
    }

    /// A finite number.
    fn number(&self, word: &str) -> Result<f64> {
        let number = word.parse().ok().filter(|v: &f64| v.is_finite());
        number.ok_or_else(|| self.broken(format!("{word:?} is no number")))
    }

    fn channel(&self, word: &str) -> Result<Channel> {
        let lower = word.to_ascii_lowercase();
        let axis = "xyz".find(lower.chars().next().unwrap_or(' '));
        match (axis, lower.get(1..)) {
            (Some(axis), Some("position")) => Ok(Channel { axis, turns: false }),
            (Some(axis), Some("rotation")) => Ok(Channel { axis, turns: true }),
            _ => Err(self.broken(format!(
                "{word:?} is no channel; Xposition or Zrotation would be"
            ))),
        }
    }

    /// The number of the line `key: number`.
    fn entry(&mut self, key: &str) -> Result<f64> {
        let line = self.next().unwrap_or("");
        match line.split_once(':') {
            Some((name, value)) if name.trim().eq_ignore_ascii_case(key) => {
                self.number(value.trim())
            }
            _ => Err(self.broken(format!("`{key}:` is expected here"))),
        }
    }
}
