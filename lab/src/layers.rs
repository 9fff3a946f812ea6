//! The soft layers' tet meshes, cut open.

use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use std::collections::BTreeSet;
use supple::Result;
use supple::model::{Avatar, Surface};
use supple_bake::mesh::MeshQuality;
use supple_pictures::{Camera, Mesh, Panel, Plane, cut_layer, from_srgb};
use supple_samples::Sample;

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
    /// Bones are shown whose middle is so far on the side that is taken off, from and to, m.
    bones_within: [f64; 2],
    /// Ball that fills the picture; everything if not given.
    near: Option<(DVec3, f64)>,
}

/// Cuts the layers open, bones seen.
fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "The volume between bones and skin, as tets: what faces outward has the colour of skin, what the cut lays \
         bare that of flesh, and what bones hold is ivory. The hand's layer is a lattice around its bones, whose \
         tets are cut by skin and bones (they carry their tissue's fraction only); the body's is a shell of prisms \
         under its skin, each cut into three tets.",
    );
    let mut rows = Vec::new();
    if runner.small() {
        let cut = Cut {
            caption: "finger, cut along its middle",
            point: DVec3::ZERO,
            normal: -DVec3::Y,
            view: DVec3::new(0.3, 1.0, -0.4),
            up: DVec3::Z,
            bones_within: [-1.0, 0.0],
            near: None,
        };
        layer(
            runner,
            Sample::Finger,
            Vec::new(),
            &[cut],
            &mut page,
            &mut rows,
        )?;
    } else {
        let bones = Sample::Hand.body()?.0.bone_surfaces;
        layer(
            runner,
            Sample::Hand,
            bones,
            &hand_cuts(),
            &mut page,
            &mut rows,
        )?;
        layer(
            runner,
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
            bones_within: [-0.008, 0.02],
            near: None,
        },
        Cut {
            caption: "middle finger, cut along it",
            point: DVec3::new(0.0, 0.0045, 0.0),
            normal: DVec3::Y,
            view: DVec3::new(-0.1, -1.0, -0.25),
            up: DVec3::Z,
            bones_within: [-0.01, 0.002],
            near: Some((DVec3::new(0.15, 0.004, -0.004), 0.064)),
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
            bones_within: [-1.0, 0.0],
            near: None,
        },
        Cut {
            caption: "belly and thighs",
            point: DVec3::new(0.0, 0.0, 0.01),
            normal: DVec3::Z,
            view: DVec3::new(0.25, -0.1, -1.0),
            up: DVec3::Y,
            bones_within: [-1.0, 0.0],
            near: Some((DVec3::new(0.0, 0.95, 0.0), 0.28)),
        },
    ]
}

/// Draws, tells and checks the layer of `sample`.
fn layer(
    runner: &Runner,
    sample: Sample,
    bones: Vec<Surface>,
    cuts: &[Cut],
    page: &mut Page,
    rows: &mut Vec<Vec<String>>,
) -> Result<()> {
    let avatar = runner.sample(sample)?;
    let panels = cuts.iter().map(|cut| {
        let plane = Plane {
            point: cut.point,
            normal: cut.normal,
        };
        let mut meshes = vec![cut_layer(&avatar.layer, &plane)];
        let framed = meshes[0].surface.positions.clone();
        // Bones whose larger part was taken off would hide what is seen, and of buried ones only splinters would be seen.
        let middle = |s: &Surface| s.positions.iter().sum::<DVec3>() / s.positions.len() as f64;
        let [from, to] = cut.bones_within;
        let kept = |s: &&Surface| {
            !s.positions.is_empty() && (from..=to).contains(&plane.distance(middle(s)))
        };
        let shown = bones.iter().filter(kept);
        meshes.extend(shown.map(|s| Mesh::new(s.clone(), from_srgb(BONE))));
        const SIZE: [usize; 2] = [640, 640];
        let camera = match cut.near {
            Some((point, radius)) => Camera::near(point, radius, cut.view, cut.up, 1.0),
            None => Camera::framing(&framed, cut.view, cut.up, 1.0),
        };
        Panel {
            image: runner.picture(&meshes, camera, SIZE),
            caption: cut.caption.into(),
        }
    });
    let name = &avatar.name;
    let sheet = runner.sheet(panels.collect(), 0, None);
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
        shell(&avatar, &skin, page);
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

/// A shell's outer side is the skin itself, but for triangles whose three columns were too short to be meshed (in
/// folds and where the skin is thin): the bones hold those, and no tet stands on them. So every outer face is a triangle
/// of the skin, and what the skin holds is what both parts enclose together, to rounding.
fn shell(avatar: &Avatar, skin: &Surface, page: &mut Page) {
    let layer = &avatar.layer;
    let node = |v: u32| layer.skin_embedding.row(v as usize).first().map(|n| n.0);
    let nodes_of = |triangle: &[u32; 3]| -> Option<[u32; 3]> {
        let [a, b, c] = triangle.map(node);
        Some(cycled([a?, b?, c?]))
    };
    let on_skin: BTreeSet<u32> = layer.skin_embedding.entries().iter().map(|e| e.0).collect();
    let boundary = layer.mesh.boundary_triangles().into_iter().map(cycled);
    let outer: BTreeSet<[u32; 3]> = boundary
        .filter(|face| face.iter().all(|n| on_skin.contains(n)))
        .collect();
    let (covered, bare): (Vec<[u32; 3]>, Vec<[u32; 3]>) = (skin.triangles.iter())
        .partition(|t| nodes_of(t).is_some_and(|nodes| outer.contains(&nodes)));
    let name = &avatar.name;
    page.check(
        format!("{name}: outer faces of the shell that are no triangles of the skin"),
        (outer.len() - covered.len()) as f64,
        "",
        Bound::AtMost(0.0),
    );
    let held = |v: &u32| node(*v).is_none_or(|n| layer.bone_of_node[n as usize].is_some());
    let loose = bare.iter().filter(|t| !t.iter().all(held)).count();
    page.check(
        format!("{name}: triangles of the skin without tissue that no bone holds"),
        loose as f64,
        "",
        Bound::AtMost(0.0),
    );
    let outside = Surface {
        positions: layer.mesh.nodes.clone(),
        triangles: outer.into_iter().collect(),
    };
    let bare = Surface {
        positions: skin.positions.clone(),
        triangles: bare,
    };
    let whole = outside.volume() + bare.volume();
    page.check(
        format!("{name}: volume inside the shell's outer side and the bare skin, off the skin's"),
        (whole / skin.volume() - 1.0).abs(),
        "",
        Bound::AtMost(1e-12),
    );
    let area = |s: &Surface| -> f64 {
        (0..s.triangles.len())
            .map(|t| s.area_vector(t).length())
            .sum()
    };
    page.text(format!(
        "{:.2} % of the {name}'s skin ({} of {} triangles) bears no tissue: there the shell is too thin to be meshed, \
         and the bones hold the skin.",
        100.0 * area(&bare) / area(skin),
        bare.triangles.len(),
        skin.triangles.len()
    ));
}

/// The same face, named from its smallest corner.
fn cycled([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        first if first == a => [a, b, c],
        first if first == b => [b, c, a],
        _ => [c, a, b],
    }
}
