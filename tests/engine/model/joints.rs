//! A host's joint matrices to frames of bones and back.

use supple::glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Mat4, Quat, Vec3};
use supple::internal::math::Random;
use supple::model::{Frame, Joint, JointBone, JointList, Skeleton, SkinJoints};

/// A chain of `bones` in a host's rig whose armature is scaled by `scale`, and what the avatar makes of it: F is the rest
/// of each node, which stands `step` further along its parent's x, turned at random.
pub struct Chain {
    pub skeleton: Skeleton,
    pub list: JointList,
    /// Rest placement of each node in its parent, the first one's in the armature; of single precision.
    local: Vec<(Quat, Vec3)>,
    armature: Mat4,
}

impl Chain {
    pub fn new(seed: u64, bones: usize, scale: f64, step: f32) -> Self {
        let random = &mut Random::new(seed);
        let local: Vec<(Quat, Vec3)> = (0..bones)
            .map(|j| (quat(random, 3.0), Vec3::X * if j == 0 { 0.0 } else { step }))
            .collect();
        let armature = Mat4::from_scale_rotation_translation(
            Vec3::splat(scale as f32),
            quat(random, 3.0),
            random.vector(2.0).as_vec3(),
        );
        let mut this = Self {
            skeleton: Skeleton {
                names: (0..bones).map(|j| format!("bone {j}")).collect(),
                parents: (0..bones)
                    .map(|j| j.checked_sub(1).map(|p| p as u32))
                    .collect(),
                joints: Vec::new(),
                aliases: Vec::new(),
                limits: Vec::new(),
            },
            list: JointList::default(),
            local,
            armature,
        };
        // The reference shape is the rest pose, so that frames have no rotation there: F is the world's linear part.
        let rest = this.world64(&vec![Quat::IDENTITY; bones]);
        this.skeleton.joints = rest.iter().map(|w| w.translation).collect();
        let joints = rest.iter().enumerate().map(|(j, w)| Joint {
            name: format!("bone {j}"),
            bone: JointBone::Is(j as u32),
            bind: DAffine3::from_mat3(w.matrix3),
        });
        // A mesh that stands in the armature's units a little aside.
        let mesh = DAffine3::from_scale_rotation_translation(
            DVec3::splat(scale),
            DQuat::from_rotation_y(0.4),
            DVec3::new(0.1, 0.2, 0.3),
        );
        let skin = SkinJoints {
            joints: (0..bones as u32).rev().collect(),
            inverse_binds: rest.iter().rev().map(|w| w.inverse() * mesh).collect(),
        };
        this.list = JointList::new(bones, joints.collect(), vec![skin]).unwrap();
        this
    }

    /// World matrices with every node turned by `turns`, multiplied in f32 as a game does.
    pub fn world(&self, turns: &[Quat]) -> Vec<Mat4> {
        let mut above = self.armature;
        let pairs = self.local.iter().zip(turns);
        pairs
            .map(|((turn, offset), own)| {
                above *= Mat4::from_rotation_translation(*turn * *own, *offset);
                above
            })
            .collect()
    }

    /// The same from the same f32 numbers without further rounding.
    fn world64(&self, turns: &[Quat]) -> Vec<DAffine3> {
        let mut above = DAffine3::from_mat4(self.armature.as_dmat4());
        let pairs = self.local.iter().zip(turns);
        pairs
            .map(|((turn, offset), own)| {
                let turn = (turn.as_dquat() * own.as_dquat()).normalize();
                above *= DAffine3::from_rotation_translation(turn, offset.as_dvec3());
                above
            })
            .collect()
    }

    pub fn frames(&self, world: &[Mat4]) -> supple::Result<Vec<Frame>> {
        let mut frames = Vec::new();
        (self.list).frames_from_world(&self.skeleton, world, &mut frames)?;
        Ok(frames)
    }
}

pub fn quat(random: &mut Random, angle: f64) -> Quat {
    DQuat::from_mat3(&random.rotation(angle)).as_quat()
}

fn turns(seed: u64, bones: usize) -> Vec<Quat> {
    let random = &mut Random::new(seed);
    (0..bones).map(|_| quat(random, 3.0)).collect()
}

fn largest(m: DMat3) -> f64 {
    m.to_cols_array().iter().fold(0.0, |a, b| a.max(b.abs()))
}

#[test]
fn rounding_in_long_chains_is_never_refused() {
    let mut farthest: f64 = 0.0;
    for seed in 0..200 {
        let scale = [1.0, 0.01, 0.0254, 100.0][seed as usize % 4];
        let chain = Chain::new(seed, 24, scale, (0.1 / scale) as f32);
        let turns = turns(1000 + seed, 24);
        let frames = chain.frames(&chain.world(&turns)).unwrap();
        let exact = chain.world64(&turns);
        for (j, (frame, exact)) in frames.iter().zip(&exact).enumerate() {
            let off = frame.rotation.transpose() * frame.rotation - DMat3::IDENTITY;
            assert!(largest(off) < 1e-14 && frame.rotation.determinant() > 0.0);
            let wanted = *exact * chain.list.joints()[j].bind.inverse();
            farthest = farthest.max(frame.position.distance(wanted.translation));
            assert!(largest(frame.rotation - wanted.matrix3) < 2e-5);
        }
    }
    println!("farthest joint: {farthest:.1e} m");
    // 24 products of rotations in f32, over 2.4 m: some 24 · 2⁻²⁴ · 2.4 m · 2.
    assert!(farthest < 1e-5);
}

#[test]
fn matrices_of_frames_are_those_the_frames_came_from() {
    for (seed, scale) in [(1, 1.0), (2, 0.01)] {
        let chain = Chain::new(seed, 9, scale, (0.1 / scale) as f32);
        let world = chain.world(&turns(seed, 9));
        let frames = chain.frames(&world).unwrap();
        let mut back = Vec::new();
        chain.list.joint_matrices(&frames, &mut back).unwrap();
        for (found, wanted) in back.iter().zip(&world) {
            let off = (*found - *wanted).to_cols_array();
            let largest = |part: &[f32]| part.iter().fold(0.0_f32, |a, b| a.max(b.abs()));
            // The linear part has the armature's scale.
            let (linear, place) = off.split_at(12);
            assert!(largest(linear) < 2e-6 * scale as f32, "{found} {wanted}");
            assert!(largest(place) < 2e-6, "{found} {wanted}");
        }
        assert_eq!(chain.frames(&back).unwrap().len(), 9);
        // More frames than bones: those of bodies.
        let more = [&frames[..], &[Frame::IDENTITY]].concat();
        let mut again = Vec::new();
        chain.list.joint_matrices(&more, &mut again).unwrap();
        assert_eq!(again, back);
    }
}

#[test]
fn skinning_matrices_say_the_same_as_world_matrices() {
    let chain = Chain::new(5, 7, 0.01, 10.0);
    let world = chain.world(&turns(6, 7));
    let skin = &chain.list.skins()[0];
    let skinning: Vec<Mat4> = (skin.joints.iter().zip(&skin.inverse_binds))
        .map(|(&j, back)| (world[j as usize].as_dmat4() * DMat4::from(*back)).as_mat4())
        .collect();
    let (mut frames, mut back) = (Vec::new(), Vec::new());
    let list = &chain.list;
    list.frames_from_skinning(&chain.skeleton, 0, &skinning, &mut frames)
        .unwrap();
    for (a, b) in frames.iter().zip(chain.frames(&world).unwrap()) {
        assert!(a.position.distance(b.position) < 1e-6, "{a:?} {b:?}");
        assert!(largest(a.rotation - b.rotation) < 2e-6);
    }
    list.skinning_matrices(0, &frames, &mut back).unwrap();
    for (found, wanted) in back.iter().zip(&skinning) {
        assert!(found.abs_diff_eq(*wanted, 2e-6), "{found} {wanted}");
    }
}

#[test]
fn bones_without_joints_move_with_others_and_riders_follow() {
    let skeleton = Skeleton {
        names: ["pelvis", "chest", "arm", "twist"].map(String::from).into(),
        parents: vec![None, Some(0), Some(1), Some(2)],
        joints: [0.0, 1.0, 2.0, 3.0].map(|y| DVec3::Y * y).into(),
        aliases: Vec::new(),
        limits: Vec::new(),
    };
    let joint = |name: &str, bone, bind| Joint {
        name: name.into(),
        bone,
        bind,
    };
    let aside = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 2.0, 3.0),
        DQuat::from_rotation_x(0.3),
        DVec3::X,
    );
    let joints = vec![
        joint("hat", JointBone::RidesOn(2), aside),
        joint("chest", JointBone::Is(1), DAffine3::IDENTITY),
    ];
    let list = JointList::new(4, joints, Vec::new()).unwrap();
    let turn =
        DAffine3::from_rotation_translation(DQuat::from_rotation_z(0.7), DVec3::new(3.0, 4.0, 5.0));
    // What a rider's matrix says is not read.
    let world = [Mat4::NAN, DMat4::from(turn).as_mat4()];
    let mut frames = Vec::new();
    list.frames_from_world(&skeleton, &world, &mut frames)
        .unwrap();
    for (frame, joint) in frames.iter().zip(&skeleton.joints) {
        // All of it moves as the chest does, whose joint was at y = 1.
        let wanted = turn.transform_point3(*joint - DVec3::Y);
        assert!(frame.position.distance(wanted) < 1e-6, "{frame:?} {wanted}");
        assert!(largest(frame.rotation - turn.matrix3) < 1e-7);
    }
    let mut back = Vec::new();
    list.joint_matrices(&frames, &mut back).unwrap();
    let hat = DMat4::from(turn * DAffine3::from_translation(DVec3::Y) * aside).as_mat4();
    assert!(back[0].abs_diff_eq(hat, 2e-6), "{} {hat}", back[0]);
}

#[test]
fn without_a_list_each_bone_is_its_joint() {
    let chain = Chain::new(3, 4, 1.0, 0.2);
    let list = JointList::of_bones(&chain.skeleton);
    let mut frames = Vec::new();
    let random = &mut Random::new(9);
    let moved: Vec<Frame> = (0..4)
        .map(|_| Frame::IDENTITY.moved(random.vector(1.0), random.vector(2.0)))
        .collect();
    let mut world = Vec::new();
    list.joint_matrices(&moved, &mut world).unwrap();
    for (frame, matrix) in moved.iter().zip(&world) {
        assert_eq!(matrix.w_axis.truncate(), frame.position.as_vec3());
        assert_eq!(matrix.x_axis.truncate(), frame.rotation.x_axis.as_vec3());
    }
    list.frames_from_world(&chain.skeleton, &world, &mut frames)
        .unwrap();
    for (a, b) in frames.iter().zip(&moved) {
        assert!(a.position.distance(b.position) < 1e-6 && largest(a.rotation - b.rotation) < 1e-6);
    }
    // In one skin that holds them all.
    let mut skinning = Vec::new();
    list.skinning_matrices(0, &moved, &mut skinning).unwrap();
    for ((frame, joint), matrix) in moved.iter().zip(&chain.skeleton.joints).zip(&skinning) {
        let place = matrix.transform_point3(joint.as_vec3());
        assert!((place.as_dvec3() - frame.position).length() < 1e-5);
    }
    let orders = JointList::of_bones_in_order(&chain.skeleton, &[2, 0, 3, 1, 7]);
    let names: Vec<&str> = orders.joints().iter().map(|j| &*j.name).collect();
    assert_eq!(names, ["bone 2", "bone 0", "bone 3", "bone 1"]);
}
