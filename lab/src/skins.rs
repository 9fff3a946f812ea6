//! An avatar's skin several times, coloured by what was measured on it.

use glam::DVec3;
use supple::collider::Shape;
use supple::model::{Avatar, Frame, Surface};
use supple_pictures::{
    Camera, ColourScale, Image, Legend, Mesh, Panel, Strip, View, from_srgb, render,
};

/// Of colliders.
pub(super) const COLLIDER: u32 = 0x8fa3b8;
/// Of handles.
pub(super) const HANDLE: u32 = 0x1a1a1a;

/// Something beside the skin.
#[derive(Clone, Debug)]
pub(super) struct Prop {
    pub shape: Shape,
    pub frame: Frame,
    /// sRGB.
    pub colour: u32,
}

/// One skin.
#[derive(Clone, Debug, Default)]
pub(super) struct Skin {
    pub caption: String,
    /// m.
    pub positions: Vec<DVec3>,
    /// One for each vertex, in the legend's unit.
    pub values: Vec<f64>,
    pub props: Vec<Prop>,
}

/// From where skins are seen, and how large.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub direction: DVec3,
    pub up: DVec3,
    /// A ball to look at in place of everything, m.
    pub focus: Option<(DVec3, f64)>,
    /// Of each picture.
    pub size: [usize; 2],
    /// Pictures in a row; 0 puts all of them into one.
    pub columns: usize,
    /// Quickly drawn.
    pub draft: bool,
}

/// Skins of `avatar` from one place in one colour scale, with the legend `title`.
pub(super) fn skin_strip(
    avatar: &Avatar,
    skins: &[Skin],
    look: Look,
    title: &str,
    scale: ColourScale,
) -> Image {
    let [width, height] = look.size;
    let aspect = width as f64 / height as f64;
    let camera = match look.focus {
        Some((centre, radius)) => Camera::near(centre, radius, look.direction, look.up, aspect),
        None => {
            let points: Vec<DVec3> = skins.iter().flat_map(|s| s.positions.clone()).collect();
            Camera::framing(&points, look.direction, look.up, aspect)
        }
    };
    let view = View::new(camera, width, height);
    let view = if look.draft { view.draft() } else { view };
    let panel = |skin: &Skin| {
        let surface = Surface {
            positions: skin.positions.clone(),
            triangles: avatar.triangles.clone(),
        };
        let mut meshes = vec![Mesh::coloured(surface, scale.colours(skin.values.clone()))];
        for prop in &skin.props {
            let colour = from_srgb(prop.colour);
            meshes.push(Mesh::collider(&prop.shape, &prop.frame, 0.3, colour));
        }
        Panel {
            image: render(&meshes, &view),
            caption: skin.caption.clone(),
        }
    };
    let strip = Strip {
        panels: skins.iter().map(panel).collect(),
        columns: look.columns,
        legend: Some(Legend {
            title: title.into(),
            scale,
        }),
        ..Strip::default()
    };
    strip.compose(view.background)
}
