//! An avatar's skin in a state.

use crate::model::{Avatar, State, Surface, pose_feature};
use crate::potential::cpu::displacement::{position, unposed_displacement};
use crate::potential::cpu::pose_blend::pose_blend;
use glam::DVec3;

/// Where the skin of `avatar` is drawn in `state`, m: x = Σ w (R (x̄ + U φ − J) + c), without a host's offsets.
pub fn posed_skin(avatar: &Avatar, state: &State) -> Surface {
    let (skeleton, points) = (&avatar.skeleton, &avatar.skin);
    let feature = pose_feature(&skeleton.parents, &state.frames);
    let mut rest = vec![DVec3::ZERO; points.len()];
    pose_blend(&points.position, &points.pose_blend, &feature, 0, &mut rest);
    let place = |(v, rest): (usize, &DVec3)| {
        let unposed = *rest + displacement_at(avatar, state, v);
        position(
            points.skinning.row(v),
            &skeleton.joints,
            &state.frames,
            unposed,
        )
    };
    Surface {
        positions: rest.iter().enumerate().map(place).collect(),
        triangles: avatar.triangles.clone(),
    }
}

/// U φ at each skin vertex, m: how far the tissue is from the skinned shape, before the pose.
pub fn skin_displacement(avatar: &Avatar, state: &State) -> Vec<DVec3> {
    let vertices = 0..avatar.skin.len();
    vertices
        .map(|v| displacement_at(avatar, state, v))
        .collect()
}

/// The same at one vertex: of coarse handles, and of the fine ones that are awake.
fn displacement_at(avatar: &Avatar, state: &State, vertex: usize) -> DVec3 {
    let coarse = unposed_displacement(avatar.skin.basis.row(vertex), &state.handles);
    if state.awake.is_empty() {
        return coarse;
    }
    let fine = avatar.fine.skin.row(vertex).iter();
    let fine = fine
        .filter_map(|&(handle, u)| Some(f64::from(u) * avatar.fine_displacement(state, handle)?));
    coarse + fine.sum::<DVec3>()
}

/// The skin in the reference shape, displaced as in `state`, m: X + U φ.
pub fn unposed_skin(avatar: &Avatar, state: &State) -> Surface {
    let displacement = skin_displacement(avatar, state);
    Surface {
        positions: (avatar.skin.position.iter().zip(displacement))
            .map(|(x, d)| *x + d)
            .collect(),
        triangles: avatar.triangles.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::potential::Potential;
    use crate::potential::cpu::CpuPotential;
    use crate::random_avatar::{random_avatar, random_state};
    use std::sync::Arc;

    /// Two ways to the same skin: by this file, and as a simulation draws it.
    #[test]
    fn the_posed_skin_is_what_a_simulation_draws() {
        let avatar = Arc::new(random_avatar(11, 4, 12, 30, 60));
        let state = random_state(12, &avatar, 0.8, 0.02);
        let mut reference = CpuPotential::new(avatar.clone(), 1).unwrap();
        let (mut drawn, mut normals) = (Vec::new(), Vec::new());
        pollster::block_on(async {
            reference
                .pose_skin(std::slice::from_ref(&state), &[], &[])
                .await?;
            reference.read_skin(0, &mut drawn, &mut normals).await
        })
        .unwrap();
        let posed = posed_skin(&avatar, &state);
        let apart = |(a, b): (&DVec3, &DVec3)| a.distance(*b);
        let error = (posed.positions.iter().zip(&drawn))
            .map(apart)
            .fold(0.0, f64::max);
        assert!(error < 1e-14, "{error:e} m");
        let unposed = unposed_skin(&avatar, &state);
        let moved = unposed.positions.iter().zip(&avatar.skin.position);
        let largest = moved.map(apart).fold(0.0, f64::max);
        assert!(largest > 1e-3, "{largest} m: handles displace it");
    }
}
