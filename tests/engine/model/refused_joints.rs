//! Joint matrices and joint lists that are refused, with joint, value and cure.

use super::joints::Chain;
use supple::glam::{DAffine3, DVec3, Mat4, Quat, Vec3, Vec4};
use supple::model::{Frame, Joint, JointBone, JointList, SkinJoints};

/// What following `world` with matrix 2 changed says; the frames that were there must stay.
fn refused(change: impl Fn(Mat4) -> Mat4) -> String {
    let chain = Chain::new(1, 4, 0.01, 10.0);
    let mut world = chain.world(&[Quat::from_rotation_x(0.3); 4]);
    world[2] = change(world[2]);
    let mut frames = vec![Frame::IDENTITY; 2];
    let result = chain
        .list
        .frames_from_world(&chain.skeleton, &world, &mut frames);
    assert_eq!(frames, vec![Frame::IDENTITY; 2]);
    result.unwrap_err().to_string()
}

#[test]
fn what_is_not_rigid_is_refused_by_joint_value_and_cure() {
    let scale = |x, y, z| Mat4::from_scale(Vec3::new(x, y, z));
    let large = refused(|w| w * scale(1.25, 1.25, 1.25));
    assert!(
        large.starts_with("joints[2]: joint \"bone 2\" is 1.2500 times as large"),
        "{large}"
    );
    assert!(large.contains("take that scale out"), "{large}");
    let uneven = refused(|w| w * scale(1.0, 1.1, 1.0));
    assert!(
        uneven.contains("sheared or scaled by 1.0000 to 1.1000"),
        "{uneven}"
    );
    let sheared = refused(|w| {
        let mut shear = Mat4::IDENTITY;
        shear.y_axis.x = 0.01;
        w * shear
    });
    assert!(sheared.contains("sheared"), "{sheared}");
    let mirrored = refused(|w| w * scale(-1.0, 1.0, 1.0));
    assert!(
        mirrored.contains("mirrored") && mirrored.contains("negative"),
        "{mirrored}"
    );
    let flat = refused(|w| w * scale(0.0, 1.0, 1.0));
    assert!(flat.contains("flat"), "{flat}");
    let nan = refused(|_| Mat4::NAN);
    assert!(
        nan.contains("bone 2") && nan.contains("not finite"),
        "{nan}"
    );
    let infinite = refused(|mut w| {
        w.w_axis.y = f32::INFINITY;
        w
    });
    assert!(infinite.contains("not finite"), "{infinite}");
    let transposed = refused(|w| w.transpose());
    assert!(transposed.contains("column-major"), "{transposed}");
    let projective = refused(|mut w| {
        w.w_axis = Vec4::new(w.w_axis.x, w.w_axis.y, w.w_axis.z, 2.0);
        w
    });
    assert!(projective.contains("0.0, 0.0, 0.0, 2.0"), "{projective}");
}

#[test]
fn the_bound_is_a_thousandth() {
    let chain = Chain::new(2, 3, 1.0, 0.1);
    let world = chain.world(&[Quat::IDENTITY; 3]);
    for (scale, good) in [
        (1.0009, true),
        (0.9991, true),
        (1.0011, false),
        (0.9989, false),
    ] {
        let scaled: Vec<Mat4> = (world.iter())
            .map(|w| *w * Mat4::from_scale(Vec3::splat(scale)))
            .collect();
        assert_eq!(chain.frames(&scaled).is_ok(), good, "{scale}");
    }
}

#[test]
fn counts_and_skins_are_checked() {
    let chain = Chain::new(1, 4, 1.0, 0.1);
    let world = chain.world(&[Quat::IDENTITY; 4]);
    let few = chain.frames(&world[..3]).unwrap_err().to_string();
    assert!(few.contains("3 matrices for 4 joints"), "{few}");
    let follow = |list: &JointList, skin, matrices: &[Mat4]| {
        let result = list.frames_from_skinning(&chain.skeleton, skin, matrices, &mut Vec::new());
        result.unwrap_err().to_string()
    };
    let few = follow(&chain.list, 0, &world[..1]);
    assert!(
        few.contains("1 matrices for 4") && few.contains("skin's joints"),
        "{few}"
    );
    let missing = follow(&chain.list, 1, &world);
    assert!(
        missing.contains("1 is not there: the file has 1"),
        "{missing}"
    );
    let hidden = JointList::new(4, chain.list.joints().to_vec(), vec![SkinJoints::default()]);
    let hidden = follow(&hidden.unwrap(), 0, &[]);
    assert!(hidden.contains("drives nothing"), "{hidden}");
    let nothing = JointList::new(4, Vec::new(), Vec::new()).unwrap();
    let nothing = nothing.frames_from_world(&chain.skeleton, &[], &mut Vec::new());
    assert!(
        nothing
            .unwrap_err()
            .to_string()
            .contains("no joint is a bone")
    );
    let frames = chain
        .list
        .joint_matrices(&[Frame::IDENTITY; 3], &mut Vec::new());
    assert!(frames.unwrap_err().to_string().contains("3 for 4 bones"));
    let short = chain.skeleton.first(2);
    let short = (chain.list).frames_from_world(&short, &world, &mut Vec::new());
    assert!(short.unwrap_err().to_string().contains("2 bones"));
}

#[test]
fn lists_that_cannot_be_are_refused() {
    let joint = |name: &str, bone, bind| Joint {
        name: name.into(),
        bone,
        bind,
    };
    let good = || joint("a", JointBone::Is(0), DAffine3::IDENTITY);
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    let nan = DAffine3::from_translation(DVec3::NAN);
    let skin = |joints: &[u32], inverse_binds: &[DAffine3]| SkinJoints {
        joints: joints.into(),
        inverse_binds: inverse_binds.into(),
    };
    let problem = |bones, joints, skins| {
        let error = JointList::new(bones, joints, skins).unwrap_err();
        error.to_string()
    };
    for (joints, hint) in [
        (
            vec![joint("a", JointBone::Is(1), DAffine3::IDENTITY)],
            "bone 1 of 1",
        ),
        (
            vec![good(), joint("a", JointBone::RidesOn(0), flat)],
            "name of another",
        ),
        (
            vec![good(), joint("b", JointBone::Is(0), DAffine3::IDENTITY)],
            "another joint is",
        ),
        (
            vec![joint("a", JointBone::Is(0), flat)],
            "without an inverse",
        ),
        (vec![joint("a", JointBone::RidesOn(0), nan)], "not finite"),
    ] {
        let found = problem(1, joints, Vec::new());
        assert!(found.contains(hint), "{found}");
    }
    for bad in [
        skin(&[1], &[DAffine3::IDENTITY]),
        skin(&[0], &[]),
        skin(&[0], &[flat]),
        skin(&[0], &[nan]),
    ] {
        let found = problem(1, vec![good()], vec![bad]);
        assert!(found.starts_with("joints.skins[0]"), "{found}");
    }
    assert!(problem(1 << 20, Vec::new(), Vec::new()).contains("at most"));
    let rides = vec![good(), joint("hat", JointBone::RidesOn(0), flat)];
    assert_eq!(JointList::new(1, rides, Vec::new()).unwrap().len(), 2);
}
