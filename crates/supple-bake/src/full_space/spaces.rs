//! Other spaces of the same body: every tet in the same basis, and every node its own handle.
//!
//! Against the first, a run shows what the cubature costs; against the second, what the basis costs.

use crate::basis::{basis_at_tets, basis_on_skin, rows_through, skinning_at_tets};
use crate::interior::InteriorField;
use supple::Result;
use supple::internal::math::Rows;
use supple::model::{Avatar, BasisEntry, PointSet, PoseBlend, SoftLayer};

/// `avatar` with every tet of its layer as a cubature point, in the same basis.
///
/// # Errors
/// [`supple::Error::Invalid`] where the avatar was written without its layer; [`supple::Error::Solve`] where pose blend
/// shapes cannot be extended into it.
pub fn all_tets(avatar: &Avatar) -> Result<Avatar> {
    avatar.needed_layer()?;
    Ok(Avatar {
        name: format!("{}, all tets", avatar.name),
        cubature: whole_layer(avatar, &avatar.layer.basis)?,
        tissue: avatar.layer.tissue.clone(),
        pose_extension: Rows::default(),
        fine: Default::default(),
        ..avatar.clone()
    })
}

/// `avatar` with every free node as a handle (U is its hat function) and every tet as a point: the
/// full-space solve, which is the reference for accuracy.
///
/// # Errors
/// As [`all_tets`].
pub fn full_space(avatar: &Avatar) -> Result<Avatar> {
    let layer = avatar.needed_layer()?;
    let mut handles = Vec::new();
    let mut basis = Rows::default();
    for (node, bone) in layer.bone_of_node.iter().enumerate() {
        let own = bone.is_none().then(|| {
            handles.push(layer.mesh.nodes[node]);
            (handles.len() as u32 - 1, 1.0)
        });
        basis.push(own);
    }
    let mut skin = avatar.skin.clone();
    skin.basis = basis_on_skin(&layer.skin_embedding, &basis);
    let followers = rows_through(&avatar.attached, &skin.basis);
    (followers.iter()).for_each(|row| skin.basis.push(row.iter().copied()));
    for _ in avatar.body_vertices(0).start..skin.len() {
        skin.basis.push(std::iter::empty());
    }
    Ok(Avatar {
        name: format!("{}, full space", avatar.name),
        skeleton: avatar.skeleton.clone(),
        joints: avatar.joints.clone(),
        up: avatar.up,
        bone_masses: avatar.bone_masses.clone(),
        springs: avatar.springs.clone(),
        handles,
        cubature: whole_layer(avatar, &basis)?,
        skin,
        triangles: avatar.triangles.clone(),
        contact_stiffness: avatar.contact_stiffness.clone(),
        attached: avatar.attached.clone(),
        pose_extension: Rows::default(),
        render_meshes: avatar.render_meshes.clone(),
        appearance: avatar.appearance.clone(),
        material: avatar.material,
        tissue: layer.tissue.clone(),
        density: avatar.density,
        captured_under_gravity: avatar.captured_under_gravity,
        fine: Default::default(),
        layer: SoftLayer {
            basis,
            ..layer.clone()
        },
        bodies: avatar.bodies.clone(),
        body_slots: avatar.body_slots,
    })
}

/// `avatar` without handles: its skin follows the bones exactly, and the tissue only weighs.
pub fn without_tissue(avatar: &Avatar) -> Avatar {
    let mut rigid = Avatar {
        name: format!("{}, without tissue", avatar.name),
        handles: Vec::new(),
        fine: Default::default(),
        ..avatar.clone()
    };
    let rows = |count: usize| (0..count).map(|_| None::<BasisEntry>).collect();
    rigid.skin.basis = rows(avatar.skin.len());
    rigid.cubature.basis = rows(avatar.cubature.len());
    rigid.layer.basis = (0..avatar.layer.basis.len())
        .map(|_| None::<(u32, f64)>)
        .collect();
    rigid
}

/// Every tet as a point of measure volume × tissue fraction.
fn whole_layer(avatar: &Avatar, basis: &Rows<(u32, f64)>) -> Result<PointSet> {
    let layer = &avatar.layer;
    let mesh = &layer.mesh;
    let tets: Vec<u32> = (0..mesh.tets.len() as u32).collect();
    let pose_blend = if avatar.skin.pose_blend.features > 0 {
        let skin = &avatar.skin;
        let tissue = |column: &[[f32; 3]]| column[..avatar.tissue_vertices()].to_vec();
        let columns = skin.pose_blend.columns.chunks_exact(skin.len().max(1));
        let of_tissue = PoseBlend {
            features: skin.pose_blend.features,
            columns: columns.flat_map(tissue).collect(),
        };
        let embedding = &layer.skin_embedding;
        InteriorField::new(mesh, &layer.bone_of_node, embedding, &skin.measure)?
            .pose_blend(&of_tissue, mesh, &tets)
    } else {
        PoseBlend::default()
    };
    Ok(PointSet {
        position: tets.iter().map(|&t| mesh.centroid(t as usize)).collect(),
        measure: (layer.tissue_fraction.iter().enumerate())
            .map(|(t, fraction)| fraction * mesh.volume(t))
            .collect(),
        skinning: skinning_at_tets(
            mesh,
            &layer.skinning,
            &tets,
            avatar.cubature.skinning.longest(),
        ),
        basis: basis_at_tets(mesh, basis, &tets),
        pose_blend,
    })
}
