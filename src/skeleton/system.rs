//! All of the skeleton's terms together.

use super::bending::{Bending, BendingSpring};
use super::bone_inertia::BoneInertia;
use super::gravity::{FrameGravity, TissueMoments};
use super::joint::JointSpring;
use super::limit::{JointLimit, LimitSpring};
use super::preload::{Held, Preload, PreloadedBone};
use super::term::{FrameHessian, FrameTerm};
use super::tracking::{Tracking, TrackingSpring};
use crate::model::{Avatar, BoneMass, Frame, InertialTarget, Skeleton, SpringBones};
use crate::potential::BlockPattern;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What stays constant while the skeleton moves.
#[derive(Clone, Debug)]
pub struct SkeletonModel {
    skeleton: Skeleton,
    masses: Vec<BoneMass>,
    /// Which bones have no mass on or below them.
    carried: Vec<bool>,
    /// Those of them that swing.
    springs: SpringBones,
    /// Mass and first moment of each.
    moments: Vec<(f64, DVec3)>,
    /// The tissue's moments.
    tissue: TissueMoments,
    /// Whether its weight loads the bones, and not the handles.
    captured_under_gravity: bool,
    /// Mass of the bones, kg.
    bone_mass: f64,
    /// Mass of the tissue, kg.
    tissue_mass: f64,
}

impl SkeletonModel {
    /// The skeleton of `avatar`.
    pub fn new(avatar: &Avatar) -> Self {
        Self {
            skeleton: avatar.skeleton.clone(),
            masses: avatar.bone_masses.clone(),
            carried: avatar.carried(),
            springs: avatar.springs.clone(),
            moments: avatar.bone_masses.iter().map(BoneMass::moments).collect(),
            tissue: TissueMoments::new(avatar),
            captured_under_gravity: avatar.captured_under_gravity,
            bone_mass: (avatar.bone_masses.iter())
                .map(|b| b.second_moment[3][3])
                .sum(),
            tissue_mass: avatar.tissue_mass(),
        }
    }

    /// The bones' tree.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// The bones that have no mass on or below them, and no terms; rising.
    pub fn carried(&self) -> impl Iterator<Item = usize> {
        (0..self.carried.len()).filter(|&j| self.carried[j])
    }

    /// What swings of those.
    pub fn springs(&self) -> &SpringBones {
        &self.springs
    }

    /// Mass of bones and tissue, kg, gravity on the latter times `tissue_gravity`.
    pub fn weighed_mass(&self, tissue_gravity: f64) -> f64 {
        self.bone_mass + tissue_gravity * self.tissue_mass
    }
}

/// What a step of the skeleton starts from.
#[derive(Clone, Copy, Debug)]
pub struct SkeletonStart<'a> {
    /// Where inertia draws to, and how the step differentiates.
    pub inertia: InertialTarget<'a>,
    /// Frames of qⁿ.
    pub current: &'a [Frame],
    /// k of the joint springs, N/m.
    pub joint_stiffness: f64,
    /// One for each bone.
    pub bending: &'a [Bending],
    /// Ranges of joints.
    pub limits: &'a [JointLimit],
    /// Targets of bones.
    pub targets: &'a [Tracking],
    /// Whose springs carry their weight beforehand.
    pub preload: Preload,
    /// Gravity, m/s².
    pub gravity: DVec3,
    /// Factor on it where it acts on tissue.
    pub tissue_gravity: f64,
    /// u of the skin, m: the tissue's weight follows; none where a host gives none.
    pub pose_offsets: &'a [[f32; 3]],
}

/// The skeleton's energies, J; as differences from qⁿ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SkeletonEnergies {
    /// Bone inertia.
    pub inertia: f64,
    /// Joint springs.
    pub joint: f64,
    /// Bending springs, and all dampers of joints.
    pub bending: f64,
    /// Limits of joints.
    pub limit: f64,
    /// Springs and dampers of targets, and springs on the skin.
    pub tracking: f64,
    /// Gravity on bones, and on the tissue at φ = 0.
    pub gravity: f64,
    /// The weight that springs carry beforehand.
    pub preload: f64,
}

impl SkeletonEnergies {
    /// Their sum.
    pub fn total(&self) -> f64 {
        self.inertia
            + self.joint
            + self.bending
            + self.limit
            + self.tracking
            + self.gravity
            + self.preload
    }
}

/// The skeleton's energy in one step of one instance.
#[derive(Clone, Debug, Default)]
pub struct SkeletonPotential {
    inertia: Vec<BoneInertia>,
    joints: Vec<JointSpring>,
    bending: Vec<BendingSpring>,
    dampers: Vec<BendingSpring>,
    limits: Vec<LimitSpring>,
    tracking: Vec<TrackingSpring>,
    gravity: FrameGravity,
    /// With the tissue's weight in any case.
    weight: FrameGravity,
    /// Where springs hold each bone.
    held: Vec<Held>,
    preload: Vec<PreloadedBone>,
}

impl SkeletonPotential {
    /// The terms of a step.
    pub fn new(model: &SkeletonModel, start: &SkeletonStart<'_>) -> Self {
        let mut out = Self::default();
        out.restart(model, start);
        out
    }

    /// [`SkeletonPotential::new`] in the memory of the last step's.
    pub fn restart(&mut self, model: &SkeletonModel, start: &SkeletonStart<'_>) {
        let skeleton = &model.skeleton;
        let moves = |bone: usize| !model.carried.get(bone).is_some_and(|c| *c);
        let parents = skeleton.parents.iter().enumerate();
        let pairs = parents
            .filter(|(child, _)| moves(*child))
            .filter_map(|(child, parent)| Some((child, (*parent)? as usize)));
        self.inertia.clear();
        let masses = model.masses.iter().enumerate().filter(|(j, _)| moves(*j));
        self.inertia.extend(
            masses.map(|(j, mass)| BoneInertia::new(j, mass, &start.inertia, &start.current[j])),
        );
        self.joints.clear();
        let joint = |(child, parent): (usize, usize)| JointSpring {
            child,
            parent,
            offset: skeleton.joints[child] - skeleton.joints[parent],
            stiffness: start.joint_stiffness,
        };
        self.joints.extend(pairs.clone().map(joint));
        self.bending.clear();
        let bending = |(child, parent): (usize, usize)| BendingSpring {
            child,
            parent,
            bending: start.bending[child],
        };
        self.bending.extend(pairs.clone().map(bending));
        self.limits.clear();
        let limits = start.limits.iter().filter(|limit| moves(limit.bone));
        self.limits.extend(limits.filter_map(|&limit| {
            Some(LimitSpring {
                child: limit.bone,
                parent: skeleton.parents[limit.bone]? as usize,
                limit,
            })
        }));
        let (current, inertia) = (start.current, &start.inertia);
        self.dampers.clear();
        for (child, parent) in pairs {
            let stopped = self.limits.iter().filter(|limit| limit.child == child);
            let stopped: f64 = stopped.map(|limit| limit.damping(current)).sum();
            let damping = start.bending[child].damping + stopped;
            if damping > 0.0 {
                let damper = BendingSpring::damper(child, parent, damping, current, inertia);
                self.dampers.push(damper);
            }
        }
        self.tracking.clear();
        let target = |&target| TrackingSpring::new(target, start.current, &start.inertia);
        let targets = start.targets.iter().filter(|target| moves(target.bone));
        self.tracking.extend(targets.map(target));
        let tissue = Some((&model.tissue, start.tissue_gravity));
        let (gravity, offsets) = (start.gravity, start.pose_offsets);
        let of_bones = tissue.filter(|_| model.captured_under_gravity);
        (self.gravity).restart(gravity, &model.moments, of_bones, current, offsets);
        self.preload.clear();
        let holds = match start.preload {
            Preload::Off => false,
            Preload::Targets => !start.targets.is_empty(),
            Preload::Pose => true,
        };
        if holds {
            self.hold(skeleton, start);
            let weight = match model.captured_under_gravity {
                true => &self.gravity,
                false => {
                    (self.weight).restart(gravity, &model.moments, tissue, current, offsets);
                    &self.weight
                }
            };
            let held = self.held.iter().enumerate().filter(|(j, _)| moves(*j));
            let preloaded = held.filter_map(|(j, held)| PreloadedBone::new(j, held, weight));
            self.preload.extend(preloaded);
        }
    }

    /// Finds where the springs hold the bones that are preloaded.
    fn hold(&mut self, skeleton: &Skeleton, start: &SkeletonStart<'_>) {
        let held = &mut self.held;
        held.clear();
        held.resize(start.current.len(), Held::default());
        for target in start.targets {
            held[target.bone] = Held {
                rotation: target.rotation.map(|_| target.frame.rotation),
                position: target.position.map(|_| target.frame.position),
            };
        }
        let pose = start.preload == Preload::Pose;
        for (j, parent) in skeleton.parents.iter().enumerate() {
            let own = held[j];
            let (rotation, position) = match *parent {
                None if pose => {
                    let frame = start.current[j];
                    (Some(frame.rotation), Some(frame.position))
                }
                None => (None, None),
                Some(p) => {
                    let (joints, Held { rotation, position }) =
                        (&skeleton.joints, held[p as usize]);
                    let offset = joints[j] - joints[p as usize];
                    let bending = &start.bending[j];
                    let bent = rotation.filter(|_| pose && bending.stiffness > 0.0);
                    let carried = rotation.zip(position).map(|(r, c)| c + r * offset);
                    (bent.map(|r| r * bending.rest_rotation), carried)
                }
            };
            held[j] = Held {
                rotation: own.rotation.or(rotation),
                position: own.position.or(position),
            };
        }
    }

    /// E(frames) − E(base), term by term.
    pub fn difference(&self, base: &[Frame], frames: &[Frame]) -> SkeletonEnergies {
        fn sum<T: FrameTerm>(terms: &[T], base: &[Frame], frames: &[Frame]) -> f64 {
            terms.iter().map(|t| t.difference(base, frames)).sum()
        }
        SkeletonEnergies {
            inertia: sum(&self.inertia, base, frames),
            joint: sum(&self.joints, base, frames),
            bending: sum(&self.bending, base, frames) + sum(&self.dampers, base, frames),
            limit: sum(&self.limits, base, frames),
            tracking: sum(&self.tracking, base, frames),
            gravity: self.gravity.difference(base, frames),
            preload: sum(&self.preload, base, frames),
        }
    }

    /// Adds the gradient and the Gauss–Newton Hessian at `frames` to those of the tissue, whose blocks are `packed` in the
    /// order of `pattern`.
    pub fn add_derivatives(
        &self,
        frames: &[Frame],
        gradient: &mut [f64],
        packed: &mut [[f64; 9]],
        pattern: &BlockPattern,
    ) {
        let hessian = &mut FrameHessian::new(packed, pattern);
        for term in self.terms() {
            term.add_derivatives(frames, gradient, hessian);
        }
    }

    /// Adds the gradient at `frames` alone.
    pub fn add_gradient(&self, frames: &[Frame], gradient: &mut [f64]) {
        for term in self.terms() {
            term.add_derivatives(frames, gradient, &mut FrameHessian::none());
        }
    }

    /// Adds what makes the Hessian exact; see [`FrameTerm::add_geometric`].
    pub fn add_geometric(&self, frames: &[Frame], packed: &mut [[f64; 9]], pattern: &BlockPattern) {
        let hessian = &mut FrameHessian::new(packed, pattern);
        for term in self.terms() {
            term.add_geometric(frames, hessian);
        }
    }

    /// Every term.
    fn terms(&self) -> impl Iterator<Item = &dyn FrameTerm> {
        fn dynamic<T: FrameTerm>(terms: &[T]) -> impl Iterator<Item = &dyn FrameTerm> {
            terms.iter().map(|t| t as &dyn FrameTerm)
        }
        dynamic(&self.inertia)
            .chain(dynamic(&self.joints))
            .chain(dynamic(&self.bending))
            .chain(dynamic(&self.dampers))
            .chain(dynamic(&self.limits))
            .chain(dynamic(&self.tracking))
            .chain(dynamic(std::slice::from_ref(&self.gravity)))
            .chain(dynamic(&self.preload))
    }

    /// The force on the bone of each target and the torque about its joint, N and N·m: its own, and that with which its weight
    /// is carried beforehand.
    pub fn target_loads<'a>(
        &'a self,
        frames: &'a [Frame],
    ) -> impl Iterator<Item = (usize, DVec3, DVec3)> + 'a {
        self.tracking.iter().map(|term| {
            let bone = term.bone();
            let (force, torque) = term.load(frames);
            let carried = (self
                .preload
                .binary_search_by_key(&bone, PreloadedBone::bone))
            .map_or((DVec3::ZERO, DVec3::ZERO), |at| {
                self.preload[at].load(frames)
            });
            (bone, force + carried.0, torque + carried.1)
        })
    }
}
