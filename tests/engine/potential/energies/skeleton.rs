//! The energies of the bones' frames.

use super::term::{Energy, Moved, Term};
use supple::glam::DVec3;
use supple::internal::cpu::HessianForm;
use supple::internal::math::{Random, rotation_exp};
use supple::internal::random_avatar;
use supple::internal::skeleton::{
    BendingSpring, BoneInertia, FrameGravity, FrameHessian, FrameTerm, Held, JointSpring,
    LimitSpring, PreloadedBone, TissueMoments, TrackingSpring,
};
use supple::model::{Avatar, Frame, InertialTarget, JointRange, Space, State};
use supple::potential::BlockPattern;
use supple::skeleton::{Bending, JointLimit, Spring, Tracking};

const BONES: usize = 3;
const DOFS: usize = 6 * BONES;
const TIME_STEP: f64 = 0.01;

fn avatar() -> Avatar {
    random_avatar(11, BONES, 4, 40, 12)
}

/// All blocks of the bones' frames.
fn pattern() -> BlockPattern {
    let space = Space {
        frames: BONES,
        handles: 0,
    };
    BlockPattern::new(space, &[], &[])
}

/// Frames that differ from the bind pose by up to `angle` rad and `distance` m.
fn frames(random: &mut Random, angle: f64, distance: f64) -> Vec<Frame> {
    let moved = |joint: &DVec3| Frame {
        rotation: random.rotation(angle),
        position: *joint + random.vector(distance),
    };
    avatar().skeleton.joints.iter().map(moved).collect()
}

/// A term about a pose.
struct Posed {
    term: Box<dyn FrameTerm>,
    frames: Vec<Frame>,
}

impl Posed {
    fn moved(&self, by: Moved) -> Vec<Frame> {
        let mut out = self.frames.clone();
        if let Some((dof, length)) = by {
            let (block, axis) = (dof / 3, DVec3::AXES[dof % 3] * length);
            let frame = &mut out[block / 2];
            *frame = match block % 2 {
                0 => frame.moved(axis, DVec3::ZERO),
                _ => frame.moved(DVec3::ZERO, axis),
            };
        }
        out
    }
}

impl Energy for Posed {
    fn difference(&mut self, from: Moved, to: Moved) -> f64 {
        self.term.difference(&self.moved(from), &self.moved(to))
    }

    fn gradient(&mut self, at: Moved) -> Vec<f64> {
        let (mut gradient, pattern) = (vec![0.0; DOFS], pattern());
        let packed = &mut vec![[0.0; 9]; BONES * (2 * BONES + 1)];
        let hessian = &mut FrameHessian::new(packed, &pattern);
        self.term
            .add_derivatives(&self.moved(at), &mut gradient, hessian);
        gradient
    }

    fn hessian(&mut self, form: HessianForm) -> Vec<Vec<f64>> {
        let mut packed = vec![[0.0; 9]; BONES * (2 * BONES + 1)];
        let pattern = pattern();
        let hessian = &mut FrameHessian::new(&mut packed, &pattern);
        self.term
            .add_derivatives(&self.frames, &mut [0.0; DOFS], hessian);
        if form == HessianForm::Exact {
            self.term.add_geometric(&self.frames, hessian);
        }
        let mut full = vec![vec![0.0; DOFS]; DOFS];
        for row in 0..2 * BONES {
            for column in 0..=row {
                let block = &packed[row * (row + 1) / 2 + column];
                for (k, value) in block.iter().enumerate() {
                    let (r, c) = (3 * row + k % 3, 3 * column + k / 3);
                    full[r][c] = *value;
                    if row != column {
                        full[c][r] = *value;
                    }
                }
            }
        }
        full
    }
}

/// Every term at a pose far from rest and, where its residual can vanish, at one where it does.
pub fn terms() -> Vec<Term> {
    let (avatar, random) = (avatar(), &mut Random::new(3));
    let (previous, current) = (frames(random, 1.0, 0.02), frames(random, 1.2, 0.02));
    let state = |frames: &[Frame]| State {
        frames: frames.to_vec(),
        handles: Vec::new(),
        awake: Vec::new(),
    };
    let (past, present) = ([state(&previous)], [state(&current)]);
    // As after a step of another length, and at rest.
    let [moving, resting] = [&past, &present].map(|past| InertialTarget {
        past,
        weights: [-1.4, 0.0, 0.0],
        drift: 0.3,
        step: TIME_STEP,
        share: None,
    });
    let far = frames(random, 1.5, 0.03);
    let term = |name: &str, rest: Option<Vec<Frame>>, make: &dyn Fn() -> Box<dyn FrameTerm>| {
        let posed = |frames| -> Box<dyn Energy> {
            Box::new(Posed {
                term: make(),
                frames,
            })
        };
        Term {
            name: name.into(),
            energy: posed(far.clone()),
            at_rest: rest.map(posed),
            linear: false,
        }
    };

    let offset = avatar.skeleton.joints[2] - avatar.skeleton.joints[0];
    let joint = JointSpring {
        child: 2,
        parent: 0,
        offset,
        stiffness: 1e4,
    };
    let mut closed = frames(random, 1.0, 0.02);
    closed[2].position = closed[0].transform(offset);

    let rest_rotation = random.rotation(0.8);
    let bending = BendingSpring {
        child: 2,
        parent: 1,
        bending: Bending {
            rest_rotation,
            stiffness: 12.0,
            damping: 0.0,
        },
    };
    let damper = BendingSpring::damper(2, 1, 0.3, &current, &moving);
    let mut unbent = frames(random, 1.0, 0.02);
    unbent[2].rotation = unbent[1].rotation * rest_rotation;

    let [target, previous_target, earlier] = [0; 3].map(|_| frames(random, 1.0, 0.02)[1]);
    let track = |rotation: Option<(f64, f64)>, position: Option<(f64, f64)>| {
        let spring = |(stiffness, damping)| Spring { stiffness, damping };
        let tracking = Tracking {
            previous: previous_target,
            earlier,
            rotation: rotation.map(spring),
            position: position.map(spring),
            ..Tracking::new(1, target)
        };
        TrackingSpring::new(tracking, &current, &moving)
    };
    let rotation = track(Some((30.0, 0.4)), None);
    let position = track(None, Some((800.0, 3.0)));
    let undamped = track(Some((30.0, 0.0)), Some((800.0, 0.0)));
    let mut on_target = frames(random, 1.0, 0.02);
    on_target[1] = target;

    let mass = &avatar.bone_masses[1];
    let moved = BoneInertia::new(1, mass, &moving, &current[1]);
    let resting = BoneInertia::new(1, mass, &resting, &current[1]);
    let moments: Vec<_> = avatar.bone_masses.iter().map(|b| b.moments()).collect();
    let gravity = FrameGravity::new(
        DVec3::new(1.0, 2.0, -9.0),
        &moments,
        Some((&TissueMoments::new(&avatar), 1.0)),
        &current,
        &[],
    );

    let held = Held {
        rotation: Some(random.rotation(1.0)),
        position: Some(DVec3::ZERO),
    };
    let preload = PreloadedBone::new(1, &held, &gravity).unwrap();

    let limit = |range| {
        let limit = JointLimit {
            bone: 2,
            range,
            stiffness: 12.0,
            damping_time: 0.02,
        };
        LimitSpring {
            child: 2,
            parent: 1,
            limit,
        }
    };
    // Out of its range about two axes, within it about the third.
    let in_box = limit(JointRange::Axes {
        axes: random.rotation(1.0),
        least: DVec3::new(-0.1, -3.0, -0.2),
        most: DVec3::new(0.1, 3.0, 0.1),
    });
    let axis = DVec3::new(0.48, -0.6, 0.64);
    let cone = |swing, twist| limit(JointRange::Cone { axis, swing, twist });
    let (swing, twist) = (cone(0.1, [-3.1, 3.1]), cone(3.1, [-0.1, 0.05]));
    let both = cone(0.1, [-0.1, 0.05]);
    // All but turned round: 3.1 rad about an axis of none of the ranges, and about one across the cone's.
    let turned = |about: DVec3| {
        let mut frames = far.clone();
        frames[2].rotation = frames[1].rotation * rotation_exp(about.normalize() * 3.1);
        frames
    };
    let (round, across) = (
        turned(DVec3::new(0.5, 0.7, -0.4)),
        turned(axis.any_orthonormal_vector() + 0.3 * axis),
    );
    let near_half_a_turn = |name: &str, limit: LimitSpring, frames: &[Frame]| Term {
        name: format!("{name}, near half a turn"),
        energy: Box::new(Posed {
            term: Box::new(limit),
            frames: frames.to_vec(),
        }),
        at_rest: None,
        linear: false,
    };

    vec![
        term("limit of axes", None, &|| Box::new(in_box)),
        term("limit of swing", None, &|| Box::new(swing)),
        term("limit of twist", None, &|| Box::new(twist)),
        near_half_a_turn("limit of axes", in_box, &round),
        near_half_a_turn("limit of swing", swing, &across),
        near_half_a_turn("limit of swing and twist", both, &round),
        term("joint", Some(closed), &|| Box::new(joint)),
        term("bending", Some(unbent), &|| Box::new(bending)),
        term("damper of a joint", None, &|| Box::new(damper)),
        term("tracking of rotation, damped", None, &|| Box::new(rotation)),
        term("tracking of position, damped", None, &|| Box::new(position)),
        term("tracking", Some(on_target), &|| Box::new(undamped)),
        term("bone inertia in motion", None, &|| Box::new(moved)),
        term("bone inertia at rest", Some(current.clone()), &|| {
            Box::new(resting)
        }),
        Term {
            linear: true,
            ..term("gravity on bones", None, &|| Box::new(gravity.clone()))
        },
        Term {
            linear: true,
            ..term("preload", None, &|| Box::new(preload))
        },
    ]
}
