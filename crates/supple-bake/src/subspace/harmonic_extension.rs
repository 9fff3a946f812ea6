//! The handles' skin values extended into the depth as harmonic functions.

use crate::basis::{Truncation, basis_at_tets, basis_on_skin, rows_through};
use crate::interior::InteriorField;
use supple::Result;
use supple::internal::math::Rows;
use supple::model::{Avatar, SoftLayer};

/// `avatar` with each U_h inside the layer minimising ½ ∫ |∇U|², its values on the skin kept and 0 at bones: still
/// a scalar basis, which kernels evaluate too. `depth` truncates the values at the nodes.
///
/// # Errors
/// As [`InteriorField::new`].
pub fn harmonic_extension(avatar: &Avatar, depth: Truncation) -> Result<Avatar> {
    let layer = &avatar.layer;
    let mesh = &layer.mesh;
    let embedding = &layer.skin_embedding;
    let field = InteriorField::new(mesh, &layer.bone_of_node, embedding, &avatar.skin.measure)?;
    let on_skin = |h: usize, v: u32| skin_value(avatar, h, v);
    let columns = field.extend(avatar.handles.len(), on_skin, |_, _| 0.0, |_, u| u.to_vec());
    let at_node = |n: usize| {
        let values = columns.iter().map(move |column| depth.apply(column[n]));
        (0..).zip(values).filter(|(_, u)| *u != 0.0)
    };
    let basis: Rows<(u32, f64)> = (0..mesh.nodes.len()).map(at_node).collect();
    let mut out = Avatar {
        name: format!("{}, harmonic", avatar.name),
        fine: Default::default(),
        ..avatar.clone()
    };
    out.skin.basis = basis_on_skin(embedding, &basis);
    let followers = rows_through(&avatar.attached, &out.skin.basis);
    (followers.iter()).for_each(|row| out.skin.basis.push(row.iter().copied()));
    let tets = super::subspace::tets_of_points(mesh, &avatar.cubature.position)?;
    out.cubature.basis = basis_at_tets(mesh, &basis, &tets);
    out.layer = SoftLayer {
        basis,
        ..layer.clone()
    };
    Ok(out)
}

/// U_h at skin vertex `v`.
pub(super) fn skin_value(avatar: &Avatar, h: usize, v: u32) -> f64 {
    let row = avatar.skin.basis.row(v as usize);
    let found = row.binary_search_by_key(&h, |entry| entry.handle as usize);
    found.map_or(0.0, |at| row[at].value)
}
