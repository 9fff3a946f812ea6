//! Spring bones as VRM files tell of them: VRMC_springBone-1.0, and `secondaryAnimation` of VRM 0.x.
//!
//! Files in the wild have broken ones: a chain that makes no sense is left out, with a word on why, and the file is read.

use super::container::File;
use super::nodes::Nodes;
use super::rig::name;
use glam::DVec3;
use serde_json::Value;
use std::collections::HashSet;

/// More spring joints than any character has.
const MOST_JOINTS: usize = 8192;
/// More colliders of spring bones than any character has.
const MOST_COLLIDERS: usize = 1024;
/// More nodes than any file skips between two joints of a chain.
const MOST_SKIPPED: usize = 1024;
/// What no hair needs more of.
const MOST: f64 = 1e6;

/// All that a file tells.
#[derive(Debug, Default)]
pub(super) struct ToldSprings {
    pub chains: Vec<ToldChain>,
    /// As the file numbers them; none of what is no collider.
    pub colliders: Vec<Option<ToldCollider>>,
    /// Chains that were left out: name and problem.
    pub broken: Vec<(String, String)>,
    /// Chains whose drag force is outside 0 to 1.
    pub clamped: usize,
    /// Collider groups and colliders that are named and not there.
    pub missing: usize,
}

/// A chain.
#[derive(Debug)]
pub(super) struct ToldChain {
    pub name: String,
    pub center: Option<usize>,
    /// Colliders of its groups, by the file's numbers, rising.
    pub colliders: Vec<usize>,
    /// The joints that turn, and where their tails are.
    pub joints: Vec<(ToldJoint, ToldTail)>,
}

/// A node that turns.
#[derive(Clone, Copy, Debug)]
pub(super) struct ToldJoint {
    pub node: usize,
    pub stiffness: f64,
    pub drag_force: f64,
    /// Power times direction.
    pub gravity: DVec3,
    pub hit_radius: f64,
}

/// Where a joint's tail is.
#[derive(Clone, Copy, Debug)]
pub(super) enum ToldTail {
    Node(usize),
    /// VRM 0.x, of a node without children: so many m on from its parent.
    Beyond(f64),
}

/// A sphere or capsule, in the coordinates of its node.
#[derive(Clone, Copy, Debug)]
pub(super) struct ToldCollider {
    pub node: usize,
    pub offset: DVec3,
    pub tail: Option<DVec3>,
    pub radius: f64,
}

impl ToldSprings {
    /// What `file` tells. VRMC_springBone goes before VRM 0.x.
    pub fn read(file: &File, nodes: &Nodes) -> Self {
        let extensions = &file.document.extensions;
        let mut reader = Reader {
            file,
            nodes,
            taken: HashSet::new(),
            out: Self::default(),
        };
        match (
            &extensions.spring_bones,
            &extensions.vrm_1,
            &extensions.vrm_0,
        ) {
            (Some(springs), ..) => reader.version_1(springs),
            (None, None, Some(vrm)) => reader.version_0(&vrm["secondaryAnimation"]),
            _ => {}
        }
        let colliders = reader.out.colliders.iter().enumerate();
        let beyond = colliders.filter(|(k, c)| *k >= MOST_COLLIDERS && c.is_some());
        reader.out.missing += beyond.count();
        reader.out.colliders.truncate(MOST_COLLIDERS);
        reader.out
    }

    /// The nodes that turn.
    pub fn heads(&self) -> impl Iterator<Item = usize> {
        let joints = self.chains.iter().flat_map(|chain| &chain.joints);
        joints.map(|(joint, _)| joint.node)
    }
}

struct Reader<'a> {
    file: &'a File,
    nodes: &'a Nodes,
    /// Nodes that a chain turns.
    taken: HashSet<usize>,
    out: ToldSprings,
}

/// Numbers of a joint.
struct Keys<'a> {
    value: &'a Value,
    stiffness: &'a str,
    direction: DVec3,
}

impl Keys<'_> {
    /// The joint of `node`; whether its drag force was outside 0 to 1.
    fn joint(&self, node: usize) -> Result<(ToldJoint, bool), String> {
        let number = |key: &str, default: f64| match &self.value[key] {
            Value::Null => Ok(default),
            told => (told.as_f64().filter(|n| n.abs() <= MOST))
                .ok_or_else(|| format!("has a {key} that is no number within 1e6")),
        };
        let positive = |key: &str, default: f64| match number(key, default)? {
            n if n < 0.0 => Err(format!("has a negative {key}")),
            n => Ok(n),
        };
        // Defaults of the schema of VRMC_springBone.
        let drag = number("dragForce", 0.5)?;
        let joint = ToldJoint {
            node,
            stiffness: positive(self.stiffness, 1.0)?,
            drag_force: drag.clamp(0.0, 1.0),
            gravity: number("gravityPower", 0.0)? * self.direction,
            hit_radius: positive("hitRadius", 0.0)?,
        };
        match joint.gravity.is_finite() && joint.gravity.abs().max_element() <= MOST {
            true => Ok((joint, joint.drag_force != drag)),
            false => Err("has a gravity out of all bounds".into()),
        }
    }
}

impl Reader<'_> {
    fn version_1(&mut self, springs: &Value) {
        let vector = |v: &Value| DVec3::from_array([0, 1, 2].map(|k| v[k].as_f64().unwrap_or(0.0)));
        let colliders = list(&springs["colliders"]).iter().map(|c| {
            let (sphere, capsule) = (&c["shape"]["sphere"], &c["shape"]["capsule"]);
            let shape = [sphere, capsule].into_iter().find(|s| s.is_object())?;
            Some(ToldCollider {
                node: index(&c["node"])?,
                offset: vector(&shape["offset"]),
                tail: capsule.is_object().then(|| vector(&capsule["tail"])),
                radius: shape["radius"].as_f64().unwrap_or(0.0),
            })
        });
        self.out.colliders = colliders.collect();
        let group = |group: &Value| {
            let mut own: Vec<usize> = (list(&group["colliders"]).iter())
                .filter_map(index)
                .filter(|k| *k < MOST_COLLIDERS)
                .collect();
            own.sort_unstable();
            own.dedup();
            own
        };
        let groups: Vec<Vec<usize>> = list(&springs["colliderGroups"]).iter().map(group).collect();
        for spring in list(&springs["springs"]) {
            let joints = list(&spring["joints"]);
            let first = joints.first().and_then(|j| self.node(&j["node"]).ok());
            let named = self.chain_name(&spring["name"], first);
            let made = self.joints_1(joints).map(|joints| ToldChain {
                name: named.clone(),
                center: index(&spring["center"]),
                colliders: self.colliders(&spring["colliderGroups"], &groups),
                joints,
            });
            self.add(named, made);
        }
    }

    /// Each joint but the last turns, with the next as its tail.
    fn joints_1(&mut self, joints: &[Value]) -> Result<Vec<(ToldJoint, ToldTail)>, String> {
        let mut out: Vec<(ToldJoint, ToldTail)> = Vec::new();
        let mut clamped = false;
        for pair in joints.windows(2) {
            let [node, tail] = [self.node(&pair[0]["node"])?, self.node(&pair[1]["node"])?];
            let above = self.nodes.upward(tail).skip(1).take(MOST_SKIPPED);
            if !{ above }.any(|n| n == node) {
                let [a, b] = [node, tail].map(|n| name(self.file, n));
                return Err(format!("has {b:?} after {a:?}, which is not above it"));
            }
            let direction = match list(&pair[0]["gravityDir"]) {
                [] => DVec3::NEG_Y,
                told => {
                    let axis = |k: usize| told.get(k).and_then(Value::as_f64);
                    let axes = [axis(0), axis(1), axis(2)].map(|a| a.unwrap_or(f64::NAN));
                    DVec3::from_array(axes)
                }
            };
            let keys = Keys {
                value: &pair[0],
                stiffness: "stiffness",
                direction,
            };
            let (joint, cut) = keys.joint(node)?;
            clamped |= cut;
            out.push((joint, ToldTail::Node(tail)));
        }
        self.out.clamped += usize::from(clamped);
        Ok(out)
    }

    /// Each node below a root turns; its tail is its first child, or 7 cm on. A root below another's is a chain of its own.
    /// Directions are those of the exporter, whose z points the other way than glTF's.
    fn version_0(&mut self, animation: &Value) {
        const BEYOND: f64 = 0.07;
        let vector = |v: &Value| {
            let axis = |name: &str| v[name].as_f64().unwrap_or(0.0);
            DVec3::new(axis("x"), axis("y"), -axis("z"))
        };
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for group in list(&animation["colliderGroups"]) {
            let first = self.out.colliders.len();
            let colliders = list(&group["colliders"]).iter().map(|c| {
                Some(ToldCollider {
                    node: index(&group["node"])?,
                    offset: vector(&c["offset"]),
                    tail: None,
                    radius: c["radius"].as_f64()?,
                })
            });
            self.out.colliders.extend(colliders);
            groups.push((first..self.out.colliders.len().min(MOST_COLLIDERS)).collect());
        }
        let springs = list(&animation["boneGroups"]);
        let roots: HashSet<usize> = (springs.iter())
            .flat_map(|spring| list(&spring["bones"]))
            .filter_map(|root| self.node(root).ok())
            .collect();
        let mut tried = HashSet::new();
        for spring in springs {
            let direction = match &spring["gravityDir"] {
                Value::Null => DVec3::NEG_Y,
                told => vector(told),
            };
            let colliders = self.colliders(&spring["colliderGroups"], &groups);
            for root in list(&spring["bones"]) {
                let root = self.node(root);
                let named = self.chain_name(&spring["comment"], root.as_ref().ok().copied());
                let keys = Keys {
                    value: spring,
                    stiffness: "stiffiness",
                    direction,
                };
                let made = root.and_then(|root| {
                    if !tried.insert(root) {
                        return Err("is told of twice".into());
                    }
                    let (joint, cut) = keys.joint(root)?;
                    let mut joints = Vec::new();
                    let mut open = vec![root];
                    while let Some(node) = open.pop() {
                        let children = &self.file.document.nodes[node].children;
                        open.extend(children.iter().filter(|child| !roots.contains(child)));
                        let tail = children.first().map(|&child| ToldTail::Node(child));
                        let tail = tail.unwrap_or(ToldTail::Beyond(BEYOND));
                        joints.push((ToldJoint { node, ..joint }, tail));
                    }
                    self.out.clamped += usize::from(cut);
                    Ok(ToldChain {
                        name: named.clone(),
                        // -1 is none.
                        center: index(&spring["center"]),
                        colliders: colliders.clone(),
                        joints,
                    })
                });
                self.add(named, made);
            }
        }
    }

    /// Adds a chain, unless it is broken or turns what another does.
    fn add(&mut self, named: String, made: Result<ToldChain, String>) {
        let checked = made.and_then(|chain| {
            let mut own = HashSet::new();
            let heads = chain.joints.iter().map(|(joint, _)| joint.node);
            for node in heads {
                if self.taken.contains(&node) || !own.insert(node) {
                    let node = name(self.file, node);
                    return Err(format!("turns {node:?}, which is turned already"));
                }
            }
            if self.taken.len() + own.len() > MOST_JOINTS {
                return Err(format!("makes more than {MOST_JOINTS} spring joints"));
            }
            self.taken.extend(own);
            Ok(chain)
        });
        match checked {
            Ok(chain) => self.out.chains.push(chain),
            Err(problem) => self.out.broken.push((named, problem)),
        }
    }

    /// The colliders of the groups that `told` names.
    fn colliders(&mut self, told: &Value, groups: &[Vec<usize>]) -> Vec<usize> {
        let mut own = vec![false; self.out.colliders.len().min(MOST_COLLIDERS)];
        for group in list(told).iter().take(MOST_COLLIDERS) {
            let found = index(group).and_then(|group| groups.get(group));
            self.out.missing += usize::from(found.is_none());
            for &k in found.into_iter().flatten() {
                if let Some(own) = own.get_mut(k) {
                    *own = true;
                }
            }
        }
        (0..own.len()).filter(|&k| own[k]).collect()
    }

    fn chain_name(&self, told: &Value, first: Option<usize>) -> String {
        let told = told.as_str().filter(|name| !name.is_empty());
        let own = told.map(String::from);
        own.or_else(|| Some(name(self.file, first?)))
            .unwrap_or_default()
    }

    fn node(&self, value: &Value) -> Result<usize, String> {
        let node = index(value).ok_or("has a joint that names no node")?;
        match node < self.nodes.parents.len() {
            true => Ok(node),
            false => Err(format!("names node {node}, which is not there")),
        }
    }
}

pub(super) fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

pub(super) fn index(value: &Value) -> Option<usize> {
    usize::try_from(value.as_u64()?).ok()
}
