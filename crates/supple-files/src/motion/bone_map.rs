//! Which bone of a motion drives which bone of an avatar.

use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use supple::model::Skeleton;
use supple::{Error, Result};
use supple_bake::{BodyPart, Part, Side, body_parts, plain_name, skeleton_parts};

/// Pairs of bones, and what is left over.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BoneMap {
    /// Index in the motion, index in the avatar; the latter rise.
    pub pairs: Vec<(usize, usize)>,
    /// Bones of the motion that drive none.
    pub unmapped_source: Vec<String>,
    /// Bones of the avatar that no bone drives.
    pub unmapped_target: Vec<String>,
}

/// What guides a [`BoneMap`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapOptions {
    /// From the motion's names to the avatar's; an empty name leaves a bone out.
    pub table: BTreeMap<String, String>,
    /// Whose bones those are that name no side, on the one hand, where the other has sides.
    pub hand: Option<Side>,
}

impl BoneMap {
    /// Maps by the table first; then by equal names; then by what the names say ([`body_parts`]); then by
    /// names that differ in case, separators or namespace. Bones of spine and neck pair from the lowest
    /// to the highest, in proportion where their numbers differ.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the table names a bone that is not there, or one twice, and where no
    /// bone is mapped at all.
    pub fn new(source: &[String], skeleton: &Skeleton, options: &MapOptions) -> Result<Self> {
        let target = &skeleton.names;
        let mut map = Builder {
            of_source: vec![None; source.len()],
            of_target: vec![None; target.len()],
        };
        let mut left_out = BTreeSet::new();
        for (from, to) in &options.table {
            let s = find(source, from, "motion")?;
            left_out.insert(s);
            if !to.is_empty() {
                let t = match skeleton.find(to) {
                    Some(t) => t,
                    None => find(target, to, "avatar")?,
                };
                if !map.pair(s, t) {
                    let problem = format!("{to:?} is driven by two bones; leave one out");
                    return Err(Error::invalid(format!("map.{from}"), problem));
                }
            }
        }
        let (from, to) = same_sides(body_parts(source), skeleton_parts(skeleton), options.hand);
        let free = |s: &usize| !left_out.contains(s);
        // SMPL's left_foot is not Mixamo's LeftFoot: what names mean decides, where both mean something.
        let agree = |s: usize, t: usize| from[s].is_none() || to[t].is_none() || from[s] == to[t];
        for s in (0..source.len()).filter(free) {
            if let Some(t) = skeleton.find(&source[s]).filter(|&t| agree(s, t)) {
                map.pair(s, t);
            }
        }
        for part in [Part::Spine, Part::Neck] {
            let chain = |parts: &[Option<BodyPart>]| -> Vec<usize> {
                let is = |j: &usize| parts[*j].is_some_and(|p| p.part == part);
                (0..parts.len()).filter(is).collect()
            };
            let (from, to) = (chain(&from), chain(&to));
            let paired = from.iter().any(|&s| map.of_source[s].is_some())
                || to.iter().any(|&t| map.of_target[t].is_some());
            for (s, t) in in_proportion(&from, &to) {
                if !paired && free(&s) {
                    map.pair(s, t);
                }
            }
        }
        for s in (0..source.len()).filter(free) {
            let Some(part) = from[s] else { continue };
            if !matches!(part.part, Part::Spine | Part::Neck)
                && let Some(t) = to.iter().position(|p| *p == Some(part))
            {
                map.pair(s, t);
            }
        }
        let spelt = |names: &[String]| names.iter().map(|n| plain_name(n)).collect::<Vec<_>>();
        let (source_spelt, target_spelt) = (spelt(source), spelt(target));
        let unknown = |s: usize, t: usize| from[s].is_none() || to[t].is_none();
        for s in (0..source.len()).filter(free) {
            let same = |t: &usize| source_spelt[s] == target_spelt[*t] && unknown(s, *t);
            let mut alike = (0..target.len()).filter(same);
            // Two bones of one spelling: neither is meant for sure.
            if let (Some(t), None) = (alike.next(), alike.next()) {
                map.pair(s, t);
            }
        }
        map.finish(source, target)
    }

    /// What was mapped and what was not, in one line.
    pub fn summary(&self) -> String {
        let list = |names: &[String]| match names {
            [] => "none".to_string(),
            names => names.join(", "),
        };
        format!(
            "{} bones mapped; unused of the motion: {}; not driven of the avatar: {}",
            self.pairs.len(),
            list(&self.unmapped_source),
            list(&self.unmapped_target)
        )
    }
}

struct Builder {
    of_source: Vec<Option<usize>>,
    of_target: Vec<Option<usize>>,
}

impl Builder {
    /// Whether both were free and are now a pair.
    fn pair(&mut self, s: usize, t: usize) -> bool {
        let free = self.of_source[s].is_none() && self.of_target[t].is_none();
        if free {
            self.of_source[s] = Some(t);
            self.of_target[t] = Some(s);
        }
        free
    }

    fn finish(self, source: &[String], target: &[String]) -> Result<BoneMap> {
        let left = |names: &[String], taken: &[Option<usize>]| -> Vec<String> {
            let free = names.iter().zip(taken).filter(|(_, t)| t.is_none());
            free.map(|(n, _)| n.clone()).collect()
        };
        let map = BoneMap {
            unmapped_source: left(source, &self.of_source),
            unmapped_target: left(target, &self.of_target),
            pairs: (self.of_target.iter().enumerate())
                .filter_map(|(t, s)| Some(((*s)?, t)))
                .collect(),
        };
        if map.pairs.is_empty() {
            let problem = format!(
                "no bone of the motion ({}) could be mapped to one of the avatar ({}); give a map",
                source.join(", "),
                target.join(", ")
            );
            return Err(Error::invalid("map", problem));
        }
        Ok(map)
    }
}

/// The bone called `name`, exactly or but for case and separators.
fn find(names: &[String], name: &str, whose: &str) -> Result<usize> {
    let exact = names.iter().position(|n| n == name);
    let alike = || names.iter().position(|n| plain_name(n) == plain_name(name));
    exact.or_else(alike).ok_or_else(|| {
        let problem = format!(
            "the {whose} has no bone {name:?}; it has {}",
            names.join(", ")
        );
        Error::invalid("map", problem)
    })
}

type Parts = Vec<Option<BodyPart>>;

/// Gives hands without sides the side of the other skeleton, or the one that is asked for.
fn same_sides(mut source: Parts, mut target: Parts, hand: Option<Side>) -> (Parts, Parts) {
    let is_hand = |p: &BodyPart| matches!(p.part, Part::Hand | Part::Finger(..));
    let sides = |parts: &Parts| -> BTreeSet<Option<Side>> {
        let hands = parts.iter().flatten().filter(|p| is_hand(p));
        hands.map(|p| p.side).collect()
    };
    let (from, to) = (sides(&source), sides(&target));
    let only = |sides: &BTreeSet<Option<Side>>| match sides.iter().flatten().collect::<Vec<_>>()[..]
    {
        [side] => Some(*side),
        _ => hand,
    };
    let settle = |parts: &mut Parts, other: &BTreeSet<Option<Side>>| {
        for p in parts.iter_mut().flatten() {
            if p.side.is_none() && is_hand(p) && !other.contains(&None) {
                p.side = only(other);
            }
        }
    };
    settle(&mut source, &to);
    settle(&mut target, &from);
    (source, target)
}

/// Pairs two chains: first with first, last with last; the shorter one is used up.
fn in_proportion(source: &[usize], target: &[usize]) -> Vec<(usize, usize)> {
    let count = source.len().min(target.len());
    let pick = |chain: &[usize], k: usize| match count {
        // One alone is the highest: that which carries the arms or the head.
        1 => chain[chain.len() - 1],
        _ => chain[(k * (chain.len() - 1) + (count - 1) / 2) / (count - 1)],
    };
    (0..count)
        .map(|k| (pick(source, k), pick(target, k)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &str) -> Vec<String> {
        names.split_whitespace().map(Into::into).collect()
    }

    fn skeleton(of: &str) -> Skeleton {
        let names = names(of);
        Skeleton {
            parents: (0..names.len() as u32).map(|j| j.checked_sub(1)).collect(),
            joints: vec![glam::DVec3::ZERO; names.len()],
            aliases: Vec::new(),
            limits: Vec::new(),
            names,
        }
    }

    fn pairs(source: &str, target: &str, options: &MapOptions) -> Vec<(String, String)> {
        let (source, target) = (names(source), skeleton(target));
        let map = BoneMap::new(&source, &target, options).unwrap();
        let target = target.names;
        let name = |(s, t): &(usize, usize)| (source[*s].clone(), target[*t].clone());
        map.pairs.iter().map(name).collect()
    }

    fn pair(s: &str, t: &str) -> (String, String) {
        (s.into(), t.into())
    }

    #[test]
    fn a_cmu_skeleton_drives_an_smpl_body() {
        let cmu = "Hips LHipJoint LeftUpLeg LeftLeg LeftFoot LeftToeBase LowerBack Spine Spine1 Neck \
                   Neck1 Head LeftShoulder LeftArm LeftForeArm LeftHand";
        let smpl = "pelvis left_hip spine1 left_knee spine2 left_ankle spine3 left_foot neck \
                    left_collar head left_shoulder left_elbow left_wrist left_hand";
        let expected = [
            pair("Hips", "pelvis"),
            pair("LeftUpLeg", "left_hip"),
            pair("LowerBack", "spine1"),
            pair("LeftLeg", "left_knee"),
            pair("Spine", "spine2"),
            pair("LeftFoot", "left_ankle"),
            pair("Spine1", "spine3"),
            pair("LeftToeBase", "left_foot"),
            pair("Neck1", "neck"),
            pair("LeftShoulder", "left_collar"),
            pair("Head", "head"),
            pair("LeftArm", "left_shoulder"),
            pair("LeftForeArm", "left_elbow"),
            pair("LeftHand", "left_wrist"),
        ];
        assert_eq!(pairs(cmu, smpl, &MapOptions::default()), expected);
    }

    #[test]
    fn chains_of_other_lengths_meet_at_their_ends() {
        let default = MapOptions::default();
        assert_eq!(
            pairs("spine chest", "spine_01 spine_02 spine_03", &default),
            [pair("spine", "spine_01"), pair("chest", "spine_03")]
        );
        assert_eq!(
            pairs("spine_01 spine_02 spine_03", "chest", &default),
            [pair("spine_03", "chest")]
        );
    }

    #[test]
    fn a_table_comes_first_and_may_leave_bones_out() {
        let options = MapOptions {
            table: BTreeMap::from([("a".into(), "b".into()), ("B".into(), String::new())]),
            hand: None,
        };
        assert_eq!(
            pairs("a B c", "b c d", &options),
            [pair("a", "b"), pair("c", "c")]
        );
        let map = BoneMap::new(&names("a B c"), &skeleton("b c d"), &options).unwrap();
        assert_eq!(
            (map.unmapped_source, map.unmapped_target),
            (names("B"), names("d"))
        );
    }

    #[test]
    fn a_hand_without_side_finds_the_one_that_is_meant() {
        let options = |hand| MapOptions {
            hand,
            ..MapOptions::default()
        };
        let right = pairs(
            "wrist index1",
            "left_wrist left_index1 right_wrist right_index1",
            &options(Some(Side::Right)),
        );
        assert_eq!(
            right,
            [pair("wrist", "right_wrist"), pair("index1", "right_index1")]
        );
        let only = pairs("wrist index1", "left_wrist left_index1", &options(None));
        assert_eq!(only.len(), 2);
    }

    #[test]
    fn what_cannot_be_mapped_is_said() {
        let wrong = |table: &[(&str, &str)], hint: &str| {
            let table = table.iter().map(|(a, b)| (a.to_string(), b.to_string()));
            let options = MapOptions {
                table: table.collect(),
                hand: None,
            };
            let error = BoneMap::new(&names("a b"), &skeleton("x y"), &options).unwrap_err();
            assert!(error.to_string().contains(hint), "{error}");
        };
        wrong(
            &[],
            "no bone of the motion (a, b) could be mapped to one of the avatar (x, y)",
        );
        wrong(&[("c", "x")], "the motion has no bone \"c\"; it has a, b");
        wrong(&[("a", "z")], "the avatar has no bone \"z\"; it has x, y");
        wrong(&[("a", "x"), ("b", "x")], "two bones");
    }
}
