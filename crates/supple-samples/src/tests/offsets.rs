//! A host's offsets of a skin reach the tissue as the model's own pose columns do.

use crate::sample::{PALM, SOFT, body_recipe, hand_recipe, map_of};
use crate::{body, hand, walk};
use supple::Result;
use supple::glam::DVec3;
use supple::internal::cpu::pose_blend::{pose_blend, pose_offset};
use supple::internal::features::pose_feature;
use supple::internal::math::Random;
use supple::model::{Avatar, Frame, PointSet, Skeleton};
use supple_bake::{Body, bake, to_bytes};

/// B_P at every point of `set`, m.
fn blended(set: &PointSet, feature: &[f64]) -> Vec<DVec3> {
    let (zeros, mut out) = (vec![DVec3::ZERO; set.len()], vec![DVec3::ZERO; set.len()]);
    pose_blend(&zeros, &set.pose_blend, feature, 0, &mut out);
    out
}

/// Ten poses of bones that are all turned by up to 0.8 rad from their bind pose.
fn random_poses(skeleton: &Skeleton) -> Vec<Vec<Frame>> {
    let random = &mut Random::new(23);
    let mut turned = |joint: &DVec3| Frame {
        rotation: random.rotation(0.8),
        position: *joint,
    };
    let mut pose = || skeleton.joints.iter().map(&mut turned).collect();
    (0..10).map(|_| pose()).collect()
}

/// That points go where `avatar`'s columns move them, to `bound` m, if the host says what the columns do to the skin; and
/// that its file grows by less than a twentieth for it.
fn check(mut avatar: Avatar, poses: &[Vec<Frame>], bound: f64) -> Result<()> {
    let (mut worst, mut farthest) = (0.0f64, 0.0f64);
    for frames in poses {
        let feature = pose_feature(&avatar.skeleton.parents, frames);
        let offsets: Vec<_> = (blended(&avatar.skin, &feature).iter())
            .map(|u| u.as_vec3().to_array())
            .collect();
        let wanted = blended(&avatar.cubature, &feature);
        for (wanted, shares) in wanted.iter().zip(avatar.pose_extension.iter()) {
            worst = worst.max(pose_offset(shares, &offsets).distance(*wanted));
            farthest = farthest.max(wanted.length());
        }
    }
    let (shares, points) = (avatar.pose_extension.entries().len(), avatar.cubature.len());
    let with = to_bytes(&avatar, None)?.len();
    avatar.pose_extension = Default::default();
    let bytes = with - to_bytes(&avatar, None)?.len();
    println!(
        "{}: points go up to {farthest:.1e} m, wrong by {worst:.1e} m; {shares} shares of {points} points, {bytes} of \
         {with} bytes",
        avatar.name
    );
    assert!(
        worst < bound && farthest > 200.0 * bound,
        "{worst:e} of {farthest:e} m"
    );
    assert!(bytes < with / 20, "{bytes} of {with} bytes");
    Ok(())
}

#[test]
fn offsets_reach_a_bodys_tissue_as_its_columns_do() -> Result<()> {
    let sample = body()?;
    let mut body = Body::of_model("body", &sample.model, &[], Vec::new());
    body.painted.insert(SOFT.into(), map_of(&sample.soft));
    let avatar = bake(&body, &body_recipe(), &mut |_| {})?.0;
    let clip = walk();
    let by_name = |frames: Vec<Frame>| -> Vec<Frame> {
        let bones = avatar.skeleton.names.iter();
        let of_bone = |name: &String| frames[clip.find(name).expect("a bone of the walk")];
        bones.map(of_bone).collect()
    };
    let walked = clip.frames.iter().step_by(4);
    let mut poses: Vec<_> = walked
        .map(|frame| by_name(clip.world_frames(frame)))
        .collect();
    poses.extend(random_poses(&avatar.skeleton));
    check(avatar, &poses, 1e-5)
}

/// In a lattice, whose nodes are not the skin's vertices; offsets go up to 2 cm, and rows lose 5e-3.
#[test]
fn offsets_reach_a_hands_tissue_as_its_columns_do() -> Result<()> {
    let sample = hand()?;
    let mut hand = Body::of_model("hand", &sample.model, &[], sample.bones);
    hand.painted.insert(PALM.into(), map_of(&sample.palmar));
    let avatar = bake(&hand, &hand_recipe(), &mut |_| {})?.0;
    let poses = random_poses(&avatar.skeleton);
    check(avatar, &poses, 1e-4)
}
