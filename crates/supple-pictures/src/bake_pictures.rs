//! Pictures of a bake: what is tissue, how deep it is and what hangs on it, handles, a column of the basis, cubature points, skin weights.

use super::{
    Camera, Colour, ColourScale, Image, Legend, Mesh, Panel, Strip, View, category_colour,
    colour_map, from_srgb, render,
};
use crate::raster::point_cloud;
use glam::DVec3;
use std::path::Path;
use supple::Result;
use supple::model::{Avatar, SkinWeight, Surface};
use supple_bake::math::NearestPoint;

/// A picture and the name of its file.
#[derive(Clone, Debug)]
pub struct BakePicture {
    /// File name without extension.
    pub name: &'static str,
    /// The picture.
    pub image: Image,
}

const SKIN: u32 = 0xd9cfc4;
const HANDLE: u32 = 0xb3203f;
/// What follows tissue, and what bones alone move.
const ATTACHED: [u32; 2] = [0x6f93b8, 0x6b7280];
/// Pixels of a panel, about.
const PANEL: f64 = 640.0;

/// The pictures of a baked avatar in its reference shape, framed for any size and posture; `parts` only where something is
/// attached.
pub fn bake_pictures(avatar: &Avatar) -> Vec<BakePicture> {
    let stage = Stage::new(avatar);
    let attached = stage.attached.iter().any(|s| !s.triangles.is_empty());
    let parts = attached.then(|| BakePicture {
        name: "parts",
        image: parts(&stage),
    });
    let of_all = [
        BakePicture {
            name: "tissue",
            image: tissue(avatar, &stage),
        },
        BakePicture {
            name: "handles",
            image: handles(avatar, &stage),
        },
        BakePicture {
            name: "basis",
            image: basis_column(avatar, &stage),
        },
        BakePicture {
            name: "cubature",
            image: cubature(avatar, &stage),
        },
        BakePicture {
            name: "skin_weights",
            image: skin_weights(avatar, &stage),
        },
    ];
    parts.into_iter().chain(of_all).collect()
}

/// Writes [`bake_pictures`] as PNG files into `folder`, which must exist.
///
/// # Errors
/// [`supple::Error::Io`].
pub fn write_bake_pictures(avatar: &Avatar, folder: impl AsRef<Path>) -> Result<()> {
    let folder = folder.as_ref();
    for picture in bake_pictures(avatar) {
        let path = folder.join(picture.name).with_extension("png");
        picture.image.write_png(&path)?;
    }
    Ok(())
}

/// The skin and what is attached to it, and where they are seen from.
struct Stage {
    skin: Surface,
    /// What follows tissue, and what bones alone move.
    attached: [Surface; 2],
    /// Largest extent, m.
    size: f64,
    /// Towards a viewer in front, to the side, up.
    front: DVec3,
    side: DVec3,
    up: DVec3,
    panel: [usize; 2],
}

impl Stage {
    /// Seen along the thinnest extent: a person from the front, a hand from its back. Up is y unless that is the
    /// thinnest, or z is the longer one of those left.
    fn new(avatar: &Avatar) -> Self {
        let points = &avatar.skin;
        // Attached vertices have no area of their own.
        let own = |t: &[u32; 3]| t.iter().any(|&v| points.measure[v as usize] > 0.0);
        let tissue = avatar.tissue_vertices();
        let follows = |v: &u32| {
            let row = (*v as usize).checked_sub(tissue);
            row.is_some_and(|k| k < avatar.attached.len() && !avatar.attached.row(k).is_empty())
        };
        let surface = |wanted: &dyn Fn(&[u32; 3]) -> bool| Surface {
            positions: points.position.clone(),
            triangles: (avatar.triangles.iter().copied().filter(wanted)).collect(),
        };
        let skin = surface(&own);
        let attached = [true, false]
            .map(|following| surface(&|t| !own(t) && t.iter().any(follows) == following));
        let used = (skin.triangles.iter().flatten()).map(|&v| skin.positions[v as usize]);
        let (low, high) = used.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| {
            (l.min(p), h.max(p))
        });
        let extent = if low.is_finite() {
            high - low
        } else {
            DVec3::ONE
        };
        let (front, up) = if extent.y < extent.x.min(extent.z) {
            (DVec3::Y, DVec3::Z)
        } else if extent.x < extent.z {
            (
                DVec3::X,
                if extent.z > extent.y {
                    DVec3::Z
                } else {
                    DVec3::Y
                },
            )
        } else {
            (DVec3::Z, DVec3::Y)
        };
        // A hand whose wrist is at the end stands on it.
        let root = avatar.skeleton.joints[0] - 0.5 * (low + high);
        let up = if root.dot(up) > 0.25 * up.dot(extent) {
            -up
        } else {
            up
        };
        let side = up.cross(front);
        let aspect = (side.dot(extent).abs() / up.dot(extent).abs()).clamp(0.6, 1.6);
        Self {
            skin,
            attached,
            size: extent.max_element(),
            front,
            side,
            up,
            panel: [PANEL * aspect.sqrt(), PANEL / aspect.sqrt()].map(|s| s as usize),
        }
    }

    /// From the front and from behind, both a little from above and from the side.
    fn directions(&self) -> [(DVec3, &'static str); 2] {
        let from = |front: f64| -(front * self.front + 0.35 * self.side + 0.2 * self.up);
        [(from(1.0), "front"), (from(-1.0), "back")]
    }

    fn panel(&self, meshes: &[Mesh], framed: &[DVec3], direction: DVec3, caption: String) -> Panel {
        let [width, height] = self.panel;
        let aspect = width as f64 / height as f64;
        let camera = Camera::framing(framed, direction, self.up, aspect);
        let view = View {
            supersampling: 2,
            lamps: 64,
            ..View::new(camera, width, height)
        };
        Panel {
            image: render(meshes, &view),
            caption,
        }
    }

    /// Both views of `meshes`.
    fn both(&self, meshes: &[Mesh], what: &str) -> Vec<Panel> {
        self.both_framed(meshes, self.corners(), what)
    }

    /// Both views of `meshes` with what is `framed` in the middle.
    fn both_framed(&self, meshes: &[Mesh], framed: Vec<DVec3>, what: &str) -> Vec<Panel> {
        let panel = |(direction, side): (DVec3, &str)| {
            self.panel(meshes, &framed, direction, format!("{what} ({side})"))
        };
        self.directions().into_iter().map(panel).collect()
    }

    /// The places of the skin's triangles.
    fn corners(&self) -> Vec<DVec3> {
        places(&self.skin).collect()
    }

    /// Those, and the places of what is attached within five times the skin's size.
    fn corners_with_attached(&self) -> Vec<DVec3> {
        let mut framed = self.corners();
        let (low, high) = (framed.iter())
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| {
                (l.min(*p), h.max(*p))
            });
        let reach = 5.0 * self.size;
        let near = |p: &DVec3| p.cmpge(low - reach).all() && p.cmple(high + reach).all();
        framed.extend(self.attached.iter().flat_map(places).filter(near));
        framed
    }

    /// The attached parts, each kind in its colour.
    fn attached_meshes(&self) -> [Mesh; 2] {
        [0, 1].map(|k| Mesh::new(self.attached[k].clone(), from_srgb(ATTACHED[k])))
    }

    fn sheet(panels: Vec<Panel>, legend: Option<Legend>, key: Vec<(Colour, String)>) -> Image {
        let strip = Strip {
            panels,
            columns: 0,
            legend,
            key,
        };
        strip.compose(from_srgb(View::BACKGROUND))
    }
}

/// The places of a surface's triangles.
fn places(surface: &Surface) -> impl Iterator<Item = DVec3> + '_ {
    let corners = surface.triangles.iter().flatten();
    corners.map(|&v| surface.positions[v as usize])
}

/// Tissue, and what is attached to it.
fn parts(stage: &Stage) -> Image {
    let mut meshes = vec![Mesh::new(stage.skin.clone(), from_srgb(SKIN))];
    meshes.extend(stage.attached_meshes());
    let panels = stage.both_framed(&meshes, stage.corners_with_attached(), "parts");
    let names = ["tissue", "follows tissue", "follows its bones"];
    let colours = [SKIN, ATTACHED[0], ATTACHED[1]].map(from_srgb);
    let key = colours.into_iter().zip(names.map(String::from));
    Stage::sheet(panels, None, key.collect())
}

/// The depth of the tissue under each of `places`, m, in the reference shape: how far the nearest node is that a bone holds;
/// 0 where none does, and of an avatar without its layer.
pub fn tissue_depths(avatar: &Avatar, places: &[DVec3]) -> Vec<f64> {
    let layer = &avatar.layer;
    let held: Vec<DVec3> = (layer.mesh.nodes.iter().zip(&layer.bone_of_node))
        .filter_map(|(place, bone)| bone.map(|_| *place))
        .collect();
    let search = NearestPoint::new(&held);
    let depth = |p: &DVec3| Some(search.distance(*p)).filter(|d| d.is_finite());
    places.iter().map(|p| depth(p).unwrap_or(0.0)).collect()
}

/// The skin by the depth of what lies under it.
fn tissue(avatar: &Avatar, stage: &Stage) -> Image {
    let depths = tissue_depths(avatar, &stage.skin.positions);
    let used = stage.skin.triangles.iter().flatten();
    let most = used.map(|&v| depths[v as usize]).fold(0.0, f64::max);
    let share = |d: &f64| colour_map(d / most.max(f64::MIN_POSITIVE));
    let skin = Mesh::coloured(stage.skin.clone(), depths.iter().map(share).collect());
    let legend = Legend {
        title: "depth of the tissue (mm)".into(),
        scale: ColourScale::up_to(1e3 * most),
    };
    Stage::sheet(stage.both(&[skin], "tissue"), Some(legend), Vec::new())
}

/// Handles as balls on the skin and what bones alone move; clothes, which would hide them, are left out. Where they lie
/// inside it, without it.
fn handles(avatar: &Avatar, stage: &Stage) -> Image {
    let radius = 0.011 * stage.size;
    let search = NearestPoint::new(&avatar.skin.position);
    let inside = |p: &&DVec3| search.distance(**p) > radius;
    let hidden = avatar.handles.iter().filter(inside).count();
    let balls = point_cloud(
        avatar
            .handles
            .iter()
            .map(|&p| (p, radius, from_srgb(HANDLE))),
    );
    let mut what = format!("{} handles", avatar.handles.len());
    let mut meshes = vec![balls];
    if hidden * 20 > avatar.handles.len() {
        what += &format!(", {hidden} of them inside: the skin is left out");
    } else {
        let [_, rigid] = stage.attached_meshes();
        meshes.extend([Mesh::new(stage.skin.clone(), from_srgb(SKIN)), rigid]);
    }
    Stage::sheet(stage.both(&meshes, &what), None, Vec::new())
}

/// A column as wide as most, of a handle that faces front or back: whole and near.
fn basis_column(avatar: &Avatar, stage: &Stage) -> Image {
    let mut strength = vec![0.0; avatar.handles.len()];
    for (row, area) in avatar.skin.basis.iter().zip(&avatar.skin.measure) {
        row.iter()
            .for_each(|u| strength[u.handle as usize] += area * u.value * u.value);
    }
    let search = NearestPoint::new(&stage.skin.positions);
    let normals = stage.skin.vertex_normals();
    let normal_at = |place: DVec3| {
        let nearest = search.nearest(place).map_or(0, |(v, _)| v as usize);
        normals.get(nearest).copied().unwrap_or(stage.front)
    };
    let facing = |h: &usize| normal_at(avatar.handles[*h]).dot(stage.front).abs() > 0.8;
    let mut shown: Vec<usize> = (0..strength.len()).filter(facing).collect();
    if shown.is_empty() {
        shown = (0..strength.len()).collect();
    }
    shown.sort_by(|a, b| strength[*a].total_cmp(&strength[*b]));
    let handle = shown.get(shown.len() / 2).copied().unwrap_or(0);
    let column: Vec<f64> = (avatar.skin.basis.iter())
        .map(|row| {
            let entry = row.iter().find(|u| u.handle as usize == handle);
            entry.map_or(0.0, |u| u.value)
        })
        .collect();
    let skin = Mesh::coloured(
        stage.skin.clone(),
        column.iter().map(|&u| colour_map(u)).collect(),
    );
    // Seen from outside, where the handle is.
    let place = avatar.handles.get(handle).copied().unwrap_or_default();
    let normal = normal_at(place);
    let towards = -(normal + 0.25 * stage.side + 0.25 * stage.up);
    let [front, back] = stage.directions();
    let whole = if normal.dot(stage.front) >= 0.0 {
        front
    } else {
        back
    };
    let reached: Vec<DVec3> = (stage.skin.positions.iter().zip(&column))
        .filter(|(_, u)| **u > 0.02)
        .map(|(p, _)| *p)
        .collect();
    let near = if reached.is_empty() {
        stage.corners()
    } else {
        reached
    };
    let meshes = [skin];
    let panels = vec![
        stage.panel(
            &meshes,
            &stage.corners(),
            whole.0,
            format!("U of handle {handle} ({})", whole.1),
        ),
        stage.panel(&meshes, &near, towards, "where it acts".into()),
    ];
    let legend = Legend {
        title: "basis function U: 1 at its handle".into(),
        scale: ColourScale::up_to(1.0),
    };
    Stage::sheet(panels, Some(legend), Vec::new())
}

/// Balls of a fifth of each point's share of the tissue, coloured by it.
fn cubature(avatar: &Avatar, stage: &Stage) -> Image {
    let weights = &avatar.cubature.measure;
    let most = weights.iter().copied().fold(0.0, f64::max);
    let ball = |(p, w): (&DVec3, &f64)| {
        let radius = (0.2 * w * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
        (*p, radius, colour_map(w / most))
    };
    // Thousands of points (every tet) are as good as the first few thousand of them spread evenly.
    const MOST: usize = 6000;
    let step = weights.len().div_ceil(MOST).max(1);
    let shown = avatar.cubature.position.iter().zip(weights).step_by(step);
    let cloud = point_cloud(shown.map(ball));
    let what = format!("{} cubature points", weights.len());
    let (title, unit) = if most < 1e-3 {
        ("weight (ml)", 1e-6)
    } else {
        ("weight (l)", 1e-3)
    };
    let legend = Legend {
        title: title.into(),
        scale: ColourScale::up_to(most / unit),
    };
    Stage::sheet(stage.both(&[cloud], &what), Some(legend), Vec::new())
}

/// A colour for each bone, mixed by the weights.
fn skin_weights(avatar: &Avatar, stage: &Stage) -> Image {
    let mixed = |row: &[SkinWeight]| {
        (row.iter()).fold([0.0; 3], |sum: Colour, w| {
            let colour = category_colour(w.bone as usize);
            std::array::from_fn(|c| sum[c] + w.weight as f32 * colour[c])
        })
    };
    let colours: Vec<Colour> = avatar.skin.skinning.iter().map(mixed).collect();
    let coloured = |surface: &Surface| Mesh::coloured(surface.clone(), colours.clone());
    let [following, rigid] = &stage.attached;
    let meshes = [&stage.skin, following, rigid].map(coloured);
    let mut used = vec![false; avatar.skeleton.len()];
    for (row, area) in avatar.skin.skinning.iter().zip(&avatar.skin.measure) {
        let heaviest = row.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
        if let (Some(w), true) = (heaviest, *area > 0.0) {
            used[w.bone as usize] = true;
        }
    }
    let key = (avatar.skeleton.names.iter().enumerate())
        .filter(|(j, _)| used[*j])
        .map(|(j, name)| (category_colour(j), name.clone()))
        .collect();
    Stage::sheet(stage.both(&meshes, "skin weights"), None, key)
}
