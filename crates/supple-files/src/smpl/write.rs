//! Parametric models in SMPL's `.npz` layout, as [`crate::smpl::read_smpl`] reads them.

use crate::npy::{encode_f64, encode_texts, encode_u32};
use crate::npz::pack;
use glam::DVec3;
use std::path::Path;
use supple::internal::write_whole;
use supple::{Error, Result};
use supple_bake::{Joints, ParametricModel};

/// Writes `model` to `path`. The same model gives the same bytes.
pub fn write_smpl(model: &ParametricModel, path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    let failed = |e| Error::format(path, "archive", format!("could not be packed: {e}"));
    let bytes = pack(&arrays(model)).map_err(failed)?;
    write_whole(path, bytes)
}

/// Every key with its `.npy` file.
fn arrays(model: &ParametricModel) -> Vec<(&'static str, Vec<u8>)> {
    let (vertices, bones) = (model.template.len(), model.parents.len());
    let numbers = |v: &[DVec3]| v.iter().flat_map(DVec3::to_array).collect::<Vec<_>>();
    let mut weights = vec![0.0; vertices * bones];
    for (v, row) in model.weights.iter().enumerate() {
        row.iter()
            .for_each(|w| weights[v * bones + w.bone as usize] = w.weight);
    }
    let parents = model.parents.iter().map(|p| p.unwrap_or(u32::MAX));
    let tree: Vec<u32> = parents.chain(0..bones as u32).collect();
    let triangles = model.triangles.as_flattened();
    let mut out = vec![
        (
            "v_template",
            encode_f64(&[vertices, 3], &numbers(&model.template)),
        ),
        ("f", encode_u32(&[model.triangles.len(), 3], triangles)),
        ("weights", encode_f64(&[vertices, bones], &weights)),
        ("kintree_table", encode_u32(&[2, bones], &tree)),
        ("joint_names", encode_texts(&model.names)),
    ];
    match &model.joints {
        Joints::Regressor(rows) => {
            let mut regressor = vec![0.0; bones * vertices];
            for (j, row) in rows.iter().enumerate() {
                row.iter()
                    .for_each(|(v, share)| regressor[j * vertices + *v as usize] = *share);
            }
            out.push(("J_regressor", encode_f64(&[bones, vertices], &regressor)));
        }
        Joints::Given {
            template,
            directions,
        } => {
            out.push(("joints", encode_f64(&[bones, 3], &numbers(template))));
            if !directions.is_empty() {
                let shape = [bones, 3, directions.len()];
                let moved = encode_f64(&shape, &transposed(directions, bones));
                out.push(("joint_directions", moved));
            }
        }
    }
    for (key, directions) in [
        ("shapedirs", &model.shape_directions),
        ("posedirs", &model.pose_directions),
    ] {
        if !directions.is_empty() {
            let shape = [vertices, 3, directions.len()];
            out.push((key, encode_f64(&shape, &transposed(directions, vertices))));
        }
    }
    out
}

/// points × 3 × count numbers of `directions[k][point]`.
fn transposed(directions: &[Vec<DVec3>], points: usize) -> Vec<f64> {
    let place = (0..points).flat_map(|v| (0..3).map(move |axis| (v, axis)));
    place
        .flat_map(|(v, axis)| directions.iter().map(move |d| d[v][axis]))
        .collect()
}
