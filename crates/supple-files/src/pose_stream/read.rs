//! Poses as JSON lines, from a file or as they come in.
//!
//! ```json
//! {"up": "y", "unit": "m", "rest": {"wrist": {"position": [0, 1, 0], "rotation": [0, 0, 0, 1]}}}
//! {"time": 0.00, "bones": {"wrist": {"position": [0, 1, 0], "rotation": [0, 0, 0, 1]}}}
//! {"time": 0.01, "bones": {"wrist": {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]}}}
//! ```
//!
//! A bone has a `rotation` (a quaternion x y z w, or three rows of a matrix), a `position`, both, or a
//! `matrix` (4 × 4, column after column). The first line is optional ([`PoseHeader`]): without it rotations
//! are away from the avatar's bind pose, positions in metres, and both in the scene's world. Bones with
//! places and no rotations are turned so that the avatar's joints lie as the places do.

use super::bone_json::bone_pose;
use crate::motion::{BonePose, BonePoses, PoseHeader, Unit};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, VecDeque};
use std::io::Read;
use std::path::{Path, PathBuf};
use supple::model::UpAxis;
use supple::{Error, Result};

/// Longest line that is taken in, bytes.
const LONGEST_LINE: usize = 1 << 22;

/// What one line may hold.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    time: Option<f64>,
    bones: Option<Map<String, Value>>,
    up: Option<UpAxis>,
    unit: Option<Unit>,
    rest: Option<Map<String, Value>>,
}

/// Takes bytes in, in pieces of any size, and gives the poses of the lines that are complete.
#[derive(Clone, Debug)]
pub struct PoseParser {
    path: PathBuf,
    unfinished: Vec<u8>,
    line: usize,
    unit: f64,
    header: PoseHeader,
    begun: bool,
    last_time: f64,
    poses: VecDeque<BonePoses>,
}

impl PoseParser {
    /// A parser; `path` names the stream in errors.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            unfinished: Vec::new(),
            line: 0,
            unit: 1.0,
            header: PoseHeader::default(),
            begun: false,
            last_time: f64::NEG_INFINITY,
            poses: VecDeque::new(),
        }
    }

    /// Takes `bytes` in.
    ///
    /// # Errors
    /// [`Error::Format`] naming the line.
    pub fn push(&mut self, mut bytes: &[u8]) -> Result<()> {
        while let Some(end) = bytes.iter().position(|b| *b == b'\n') {
            self.unfinished.extend(&bytes[..end]);
            self.end_line()?;
            bytes = &bytes[end + 1..];
        }
        self.unfinished.extend(bytes);
        if self.unfinished.len() > LONGEST_LINE {
            self.line += 1;
            return Err(self.broken(format!("is longer than {LONGEST_LINE} bytes")));
        }
        Ok(())
    }

    /// Takes the last line in, where no line end follows it.
    ///
    /// # Errors
    /// As [`PoseParser::push`].
    pub fn finish(&mut self) -> Result<()> {
        match self.unfinished.is_empty() {
            true => Ok(()),
            false => self.end_line(),
        }
    }

    /// The next pose, if one is complete.
    pub fn next_pose(&mut self) -> Option<BonePoses> {
        self.poses.pop_front()
    }

    /// What was said before the first pose.
    pub fn header(&self) -> &PoseHeader {
        &self.header
    }

    fn broken(&self, problem: impl Into<String>) -> Error {
        Error::format(&self.path, format!("line {}", self.line), problem)
    }

    fn end_line(&mut self) -> Result<()> {
        self.line += 1;
        let bytes = std::mem::take(&mut self.unfinished);
        if bytes.iter().all(u8::is_ascii_whitespace) {
            return Ok(());
        }
        let line: Line = serde_json::from_slice(&bytes).map_err(|e| {
            // The line is ours, not that of the piece of JSON.
            self.broken(e.to_string().replace(" at line 1 column ", " at column "))
        })?;
        match (line.time, line.bones) {
            (Some(time), Some(bones)) => {
                if line.up.is_some() || line.unit.is_some() || line.rest.is_some() {
                    return Err(self.broken("up, unit and rest go into a line before all poses"));
                }
                if time <= self.last_time {
                    let problem = format!("time {time} does not come after {}", self.last_time);
                    return Err(self.broken(problem));
                }
                if bones.is_empty() {
                    return Err(self.broken("bones: holds none"));
                }
                self.last_time = time;
                self.begun = true;
                let bones = self.bones("bones", bones)?;
                self.poses.push_back(BonePoses { time, bones });
            }
            (None, None) if !self.begun => {
                self.begun = true;
                if let Some(unit) = line.unit {
                    self.unit = unit.metres().map_err(|e| self.broken(e.to_string()))?;
                }
                self.header = PoseHeader {
                    up: line.up,
                    rest: self.bones("rest", line.rest.unwrap_or_default())?,
                };
            }
            (None, _) => return Err(self.broken("time is missing")),
            (_, None) => return Err(self.broken("bones are missing")),
        }
        Ok(())
    }

    fn bones(&self, key: &str, bones: Map<String, Value>) -> Result<BTreeMap<String, BonePose>> {
        let bone = |(name, value): (String, Value)| {
            let pose = bone_pose(&value, self.unit);
            let pose = pose.map_err(|problem| self.broken(format!("{key}.{name}{problem}")));
            Ok((name, pose?))
        };
        bones.into_iter().map(bone).collect()
    }
}

/// Poses from a file, or from anything that gives bytes as they come in.
pub struct PoseReader<R> {
    bytes: R,
    parser: PoseParser,
    ended: bool,
}

impl<R: Read> PoseReader<R> {
    /// A reader of `bytes`; `path` names it in errors.
    pub fn new(bytes: R, path: impl AsRef<Path>) -> Self {
        Self {
            bytes,
            parser: PoseParser::new(path.as_ref()),
            ended: false,
        }
    }

    /// What is said before the first pose; waits for that.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Format`] naming the line.
    pub fn header(&mut self) -> Result<PoseHeader> {
        while self.parser.poses.is_empty() && self.read()? {}
        Ok(self.parser.header().clone())
    }

    /// The next pose; waits for it. `None` at the end.
    ///
    /// # Errors
    /// As [`PoseReader::header`].
    pub fn next_pose(&mut self) -> Result<Option<BonePoses>> {
        loop {
            if let Some(poses) = self.parser.next_pose() {
                return Ok(Some(poses));
            }
            if !self.read()? {
                return Ok(None);
            }
        }
    }

    /// Takes in what there is; false at the end.
    fn read(&mut self) -> Result<bool> {
        if self.ended {
            return Ok(false);
        }
        let mut piece = [0; 1 << 14];
        match self.bytes.read(&mut piece) {
            Ok(0) => {
                self.ended = true;
                self.parser.finish()?;
            }
            Ok(count) => self.parser.push(&piece[..count])?,
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) => return Err(Error::io(&self.parser.path, e)),
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    const GOOD: &str = r#"{"up": "y", "unit": "cm", "rest": {"wrist": {"position": [0, 100, 0]}}}

{"time": 0, "bones": {"wrist": {"position": [0, 1, 0], "rotation": [0, 0, 0, 1]}}}
{"time": 0.5, "bones": {"wrist": {"rotation": [[0, -1, 0], [1, 0, 0], [0, 0, 1]]}, "µ": {"position": [1, 2, 3]}}}
{"time": 1.0, "bones": {"wrist": {"matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]}}}"#;

    fn parse(pieces: &[&[u8]]) -> Result<(PoseHeader, Vec<BonePoses>)> {
        let mut parser = PoseParser::new("stream");
        for piece in pieces {
            parser.push(piece)?;
        }
        parser.finish()?;
        let poses = std::iter::from_fn(|| parser.next_pose()).collect();
        Ok((parser.header().clone(), poses))
    }

    #[test]
    fn lines_may_be_split_at_any_byte() {
        let whole = parse(&[GOOD.as_bytes()]).unwrap();
        assert_eq!(whole.0.up, Some(UpAxis::Y));
        assert_eq!(whole.0.rest["wrist"].position, Some(DVec3::Y));
        assert_eq!(whole.1.len(), 3);
        let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
        for pose in &whole.1[1..] {
            assert!(pose.bones["wrist"].rotation.unwrap().angle_between(quarter) < 1e-7);
        }
        let matrix = whole.1[2].bones["wrist"].position.unwrap();
        assert!((matrix - DVec3::new(0.05, 0.06, 0.07)).length() < 1e-15);
        for at in 0..=GOOD.len() {
            let (a, b) = GOOD.as_bytes().split_at(at);
            assert_eq!(parse(&[a, b]).unwrap(), whole, "split at {at}");
        }
        let bytes: Vec<&[u8]> = GOOD.as_bytes().chunks(1).collect();
        assert_eq!(parse(&bytes).unwrap(), whole);
    }

    /// A pose is there as soon as its line is: nothing waits for the stream's end.
    #[test]
    fn poses_come_out_as_they_come_in() {
        let mut parser = PoseParser::new("stream");
        for (count, line) in GOOD.lines().enumerate() {
            parser.push(line.as_bytes()).unwrap();
            assert!(parser.next_pose().is_none());
            parser.push(b"\n").unwrap();
            assert_eq!(parser.next_pose().is_some(), count >= 2);
        }
    }

    #[test]
    fn what_is_wrong_is_named_by_its_line() {
        let wrong = |second: &str, hint: &str| {
            let first = r#"{"time": 1, "bones": {"a": {"position": [0, 0, 0]}}}"#;
            let error = parse(&[first.as_bytes(), b"\r\n", second.as_bytes()]).unwrap_err();
            let text = error.to_string();
            assert!(matches!(error, Error::Format { .. }), "{text}");
            assert!(
                text.starts_with("stream: line 2: ") && text.contains(hint),
                "{text}"
            );
        };
        wrong("{", "EOF");
        wrong("[]", "");
        wrong(r#"{"time": 2}"#, "bones are missing");
        wrong(r#"{"bones": {}}"#, "time is missing");
        wrong(r#"{"time": 2, "bones": {}}"#, "holds none");
        wrong(
            r#"{"time": 1, "bones": {"a": {"position": [0, 0, 0]}}}"#,
            "does not come after 1",
        );
        wrong(
            r#"{"time": 2, "bones": {"a": {"position": [0, 0]}}}"#,
            "bones.a.position: 3 numbers",
        );
        wrong(
            r#"{"time": 2, "bones": {"a": {"position": [0, 0, 1e999]}}}"#,
            "number out of range",
        );
        wrong(
            r#"{"time": 2, "bones": {"a": {"rotation": [0, 0, 0, 2]}}}"#,
            "length 2",
        );
        wrong(
            r#"{"time": 2, "bones": {"a": {"rotation": [1, 2]}}}"#,
            "bones.a.rotation: 4 numbers",
        );
        wrong(
            r#"{"time": 2, "bones": {"a": {"turn": [1, 2]}}}"#,
            "bones.a.turn",
        );
        wrong(r#"{"time": 2, "bones": {"a": {}}}"#, "neither");
        wrong(r#"{"up": "y"}"#, "time is missing");
        wrong(r#"{"time": 2, "bone": {}}"#, "unknown field");
        wrong(
            r#"{"time": 2, "bones": {"a": {"matrix": [1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,0,1]}}}"#,
            "no rotation",
        );
        wrong(&"x".repeat(LONGEST_LINE + 1), "longer than");
    }
}
