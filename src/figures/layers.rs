//! The soft layers' tet meshes, cut open.

use super::{Bound, Figure, Page, Studio};
use crate::Result;
use crate::bake::mesh::MeshQuality;
use crate::export::{Camera, Mesh, Panel, Plane, cut_layer, from_srgb};
use crate::load::Sample;
use crate::model::{Avatar, Surface};
use glam::DVec3;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "layers",
    title: "The soft layers' tet meshes, cut open",
    paper: "figure 4",
    draw,
};

const BONE: u32 = 0xf1ead6;

/// One view of a layer: what is cut away, and from where it is looked at.
struct Cut {
    caption: &'static str,
    point: DVec3,
    normal: DVec3,
    view: DVec3,
    up: DVec3,
    /// Bones are shown whose middle is at most so far on the side that is taken off, m.
    bones_within: f64,
    /// Ball that fills the picture; everything if not given.
    near: Option<(DVec3, f64)>,
}

/// Cuts the layers open, bones seen.
fn draw(studio: &Studio) -> Result<Page> {
    let mut page = Page::new(
        "The volume between bones and skin, as tets: what faces outward has the colour of skin, what the cut lays \
         bare that of flesh, and what bones hold is ivory. The hand's layer is a lattice around its bones, whose \
         tets are cut by skin and bones (they carry their tissue's fraction only); the body's is a shell of prisms \
         under its skin, each cut into three tets.",
    );
    let mut rows = Vec::new();
    if studio.small() {
        let cut = Cut {
            caption: "finger, cut along its middle",
            point: DVec3::ZERO,
            normal: -DVec3::Y,
            view: DVec3::new(0.3, 1.0, -0.4),
            up: DVec3::Z,
            bones_within: 0.0,
            near: None,
        };
        layer(
            studio,
            Sample::Finger,
            Vec::new(),
            &[cut],
            &mut page,
            &mut rows,
        )?;
    } else {
        let bones = Sample::Hand.body()?.0.bone_surfaces;
        layer(
            studio,
            Sample::Hand,
            bones,
            &hand_cuts(),
            &mut page,
            &mut rows,
        )?;
        layer(
            studio,
            Sample::Body,
            Vec::new(),
            &body_cuts(),
            &mut page,
            &mut rows,
        )?;
    }
    let columns = [
        "layer",
        "nodes",
        "tets",
        "tissue (ml)",
        "inverted",
        "median dihedral angle (°)",
    ];
    page.table(
        "The meshes (the paper's: hand 20,214 nodes, 88,716 tets; body 10,111 and 41,585)",
        &columns,
        rows,
    );
    Ok(page)
}

fn hand_cuts() -> [Cut; 2] {
    [
        Cut {
            caption: "hand, its back taken off",
            point: DVec3::ZERO,
            normal: DVec3::Z,
            view: DVec3::new(0.15, 0.3, -1.0),
            up: DVec3::X,
            bones_within: 0.02,
            near: None,
        },
        Cut {
            caption: "middle finger, cut along it",
            point: DVec3::new(0.0, 0.0045, 0.0),
            normal: DVec3::Y,
            view: DVec3::new(-0.1, -1.0, -0.25),
            up: DVec3::Z,
            bones_within: 0.002,
            near: Some((DVec3::new(0.13, 0.004, -0.008), 0.055)),
        },
    ]
}

fn body_cuts() -> [Cut; 2] {
    [
        Cut {
            caption: "body, its front taken off",
            point: DVec3::new(0.0, 0.0, 0.01),
            normal: DVec3::Z,
            view: DVec3::new(0.25, -0.1, -1.0),
            up: DVec3::Y,
            bones_within: 0.0,
            near: None,
        },
        Cut {
            caption: "belly and thighs",
            point: DVec3::new(0.0, 0.0, 0.01),
            normal: DVec3::Z,
            view: DVec3::new(0.25, -0.1, -1.0),
            up: DVec3::Y,
            bones_within: 0.0,
            near: Some((DVec3::new(0.0, 0.95, 0.0), 0.28)),
        },
    ]
}

/// Draws, tells and checks the layer of `sample`.
fn layer(
    studio: &Studio,
    sample: Sample,
    bones: Vec<Surface>,
    cuts: &[Cut],
    page: &mut Page,
    rows: &mut Vec<Vec<String>>,
) -> Result<()> {
    let avatar = studio.sample(sample)?;
    let panels = cuts.iter().map(|cut| {
        let plane = Plane {
            point: cut.point,
            normal: cut.normal,
        };
        let mut meshes = vec![cut_layer(&avatar.layer, &plane)];
        let framed = meshes[0].surface.positions.clone();
        // Bones whose larger part was taken off would hide what is seen.
        let middle = |s: &Surface| s.positions.iter().sum::<DVec3>() / s.positions.len() as f64;
        let kept =
            |s: &&Surface| !s.positions.is_empty() && plane.distance(middle(s)) <= cut.bones_within;
        let shown = bones.iter().filter(kept);
        meshes.extend(shown.map(|s| Mesh::new(s.clone(), from_srgb(BONE))));
        const SIZE: [usize; 2] = [640, 640];
        let camera = match cut.near {
            Some((point, radius)) => Camera::near(point, radius, cut.view, cut.up, 1.0),
            None => Camera::framing(&framed, cut.view, cut.up, 1.0),
        };
        Panel {
            image: studio.picture(&meshes, camera, SIZE),
            caption: cut.caption.into(),
        }
    });
    let name = &avatar.name;
    let sheet = studio.sheet(panels.collect(), 0, None);
    page.picture(name, sheet, format!("soft layer of the {name}, cut open"));

    let quality = MeshQuality::of(&avatar.layer.mesh);
    let tissue: f64 = tissue_volume(&avatar);
    rows.push(vec![
        name.clone(),
        quality.nodes.to_string(),
        quality.tets.to_string(),
        format!("{:.1}", 1e6 * tissue),
        quality.inverted.to_string(),
        format!("{:.1}", quality.median_dihedral),
    ]);
    let inverted = quality.inverted as f64;
    page.check(
        format!("{name}: inverted tets"),
        inverted,
        "",
        Bound::AtMost(0.0),
    );
    let skin = Surface {
        positions: avatar.skin.position.clone(),
        triangles: avatar.triangles.clone(),
    };
    if bones.is_empty() {
        // A shell's outer side is the skin, but for folds that the mesher leaves out.
        let outer = outer_volume(&avatar);
        let error = (outer / skin.volume() - 1.0).abs();
        page.check(
            format!("{name}: volume inside the shell's outer side, off the skin's"),
            error,
            "",
            Bound::AtMost(1e-3),
        );
    } else {
        let bones: f64 = bones.iter().map(Surface::volume).sum();
        let error = (tissue / (skin.volume() - bones) - 1.0).abs();
        page.check(
            format!("{name}: volume of tissue, off skin less bones"),
            error,
            "",
            Bound::AtMost(0.01),
        );
    }
    Ok(())
}

/// Σ fraction · volume, m³.
fn tissue_volume(avatar: &Avatar) -> f64 {
    let fractions = avatar.layer.tissue_fraction.iter().enumerate();
    fractions
        .map(|(t, f)| f * avatar.layer.mesh.volume(t))
        .sum()
}

/// Volume inside the boundary faces that no bone holds, m³.
fn outer_volume(avatar: &Avatar) -> f64 {
    let layer = &avatar.layer;
    let held = |n: &u32| layer.bone_of_node[*n as usize].is_some();
    let boundary = layer.mesh.boundary_triangles().into_iter();
    let outer = Surface {
        positions: layer.mesh.nodes.clone(),
        triangles: boundary.filter(|face| !face.iter().all(held)).collect(),
    };
    outer.volume()
}
