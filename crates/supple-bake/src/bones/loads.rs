//! What hangs on the bones, and how those that carry nothing leave an avatar.

use crate::body::Body;
use glam::DAffine3;
use supple::Result;
use supple::internal::math::Rows;
use supple::model::{Avatar, Joint, JointBone, JointList, SkinWeight};

/// Whether anything hangs on each bone or on one below it.
pub(crate) struct BoneLoads {
    /// Skin, tissue or a surface of its own: what has mass. Roots count as such.
    pub mass: Vec<bool>,
    /// That, or what is attached: hair, a skirt.
    pub anything: Vec<bool>,
}

impl BoneLoads {
    /// Of the bones of `body`. Where blend shapes depend on the pose, all bones say the pose, and all count as loaded.
    pub fn of(body: &Body) -> Self {
        let bones = body.skeleton.len();
        if body.pose_blend.features > 0 {
            return Self {
                mass: vec![true; bones],
                anything: vec![true; bones],
            };
        }
        let parents = &body.skeleton.parents;
        let mut mass: Vec<bool> = parents.iter().map(Option::is_none).collect();
        let mark = |own: &mut Vec<bool>, bone: u32| {
            if let Some(slot) = own.get_mut(bone as usize) {
                *slot = true;
            }
        };
        let weighted = |rows: &Rows<SkinWeight>| -> Vec<u32> {
            let entries = rows.entries().iter().filter(|w| w.weight != 0.0);
            entries.map(|w| w.bone).collect()
        };
        let held = body.layer.bone_of_node.iter().flatten().copied();
        let surfaces = (0..).zip(&body.bone_surfaces);
        let own = surfaces
            .filter(|(_, s)| !s.triangles.is_empty())
            .map(|(bone, _)| bone);
        let of_skin = weighted(&body.skinning);
        for bone in of_skin.into_iter().chain(held).chain(own) {
            mark(&mut mass, bone);
        }
        let mut anything = mass.clone();
        for bone in body.attachments.iter().flat_map(|a| weighted(&a.skinning)) {
            mark(&mut anything, bone);
        }
        for loaded in [&mut mass, &mut anything] {
            for bone in (0..bones).rev() {
                if let Some(p) = parents[bone].filter(|_| loaded[bone]) {
                    loaded[p as usize] = true;
                }
            }
        }
        Self { mass, anything }
    }
}

/// Takes the bones that are not `kept` out of `avatar`: nothing hangs on them, and none is a root or above one that stays.
/// Their joints and spring colliders ride on the nearest bone above that stays, where the bind pose has them. The new number of each bone.
///
/// # Errors
/// What [`JointList::new`] says.
pub(crate) fn drop_bones(avatar: &mut Avatar, kept: &[bool]) -> Result<()> {
    if kept.iter().all(|k| *k) {
        return Ok(());
    }
    let skeleton = &mut avatar.skeleton;
    // The bone that stays for each bone, and the new number of those.
    let mut stays: Vec<usize> = Vec::with_capacity(kept.len());
    let mut number: Vec<u32> = Vec::with_capacity(kept.len());
    let mut count = 0;
    for (bone, parent) in skeleton.parents.iter().enumerate() {
        let above = parent.map_or(bone, |p| stays[p as usize]);
        stays.push(if kept[bone] { bone } else { above });
        number.push(count);
        count += u32::from(kept[bone]);
    }
    let new = |bone: u32| number[stays[bone as usize]];
    let joints = avatar.joints.joints().iter().map(|joint| {
        let old = joint.bone.bone();
        let bone = number[stays[old]];
        let offset = skeleton.joints[old] - skeleton.joints[stays[old]];
        Joint {
            name: joint.name.clone(),
            bone: match joint.bone {
                JointBone::Is(_) if kept[old] => JointBone::Is(bone),
                _ => JointBone::RidesOn(bone),
            },
            bind: if kept[old] {
                joint.bind
            } else {
                DAffine3::from_translation(offset) * joint.bind
            },
        }
    });
    let joints = joints.collect();
    let skins = avatar.joints.skins().to_vec();
    avatar.joints = JointList::new(count as usize, joints, skins)?;

    let springs = &mut avatar.springs;
    springs.retain_joints(|joint| kept[joint.bone as usize]);
    let joints = springs.joints.iter_mut().map(|joint| &mut joint.bone);
    let centers = springs.chains.iter_mut().flat_map(|c| &mut c.center);
    joints.chain(centers).for_each(|bone| *bone = new(*bone));
    for collider in &mut springs.colliders {
        let old = collider.bone as usize;
        let offset = skeleton.joints[old] - skeleton.joints[stays[old]];
        collider.offset += offset;
        (collider.tail.iter_mut()).for_each(|tail| *tail += offset);
        collider.bone = new(collider.bone);
    }

    retain(&mut skeleton.names, kept);
    retain(&mut skeleton.joints, kept);
    retain(&mut skeleton.parents, kept);
    retain(&mut avatar.bone_masses, kept);
    (skeleton.parents.iter_mut().flatten()).for_each(|p| *p = new(*p));
    // A name of one that is gone would be another's.
    skeleton.aliases.retain(|(_, bone)| kept[*bone as usize]);
    skeleton.aliases.iter_mut().for_each(|a| a.1 = new(a.1));
    skeleton.limits.retain(|(bone, _)| kept[*bone as usize]);
    skeleton.limits.iter_mut().for_each(|l| l.0 = new(l.0));
    let layer = &mut avatar.layer;
    for rows in [
        &mut avatar.skin.skinning,
        &mut avatar.cubature.skinning,
        &mut layer.skinning,
    ] {
        // A weight of 0 may name one that is gone.
        let row = |row: &[SkinWeight]| -> Vec<SkinWeight> {
            let stay = row.iter().filter(|w| kept[w.bone as usize]);
            let renamed = |w: &SkinWeight| SkinWeight {
                bone: new(w.bone),
                ..*w
            };
            stay.map(renamed).collect()
        };
        *rows = rows.iter().map(row).collect();
    }
    (layer.bone_of_node.iter_mut().flatten()).for_each(|bone| *bone = new(*bone));
    Ok(())
}

/// Keeps the values of those that are `kept`.
pub(crate) fn retain<T>(values: &mut Vec<T>, kept: &[bool]) {
    let mut at = kept.iter();
    values.retain(|_| at.next().is_some_and(|k| *k));
}
