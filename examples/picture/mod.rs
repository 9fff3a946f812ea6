//! A strip of pictures of what a world holds, for the examples.

use std::path::Path;
use supple::collider::Collider;
use supple::glam::DVec3;
use supple::model::{Frame, Surface};
use supple::world::InstanceId;
use supple::{Result, World};
use supple_pictures::{
    Camera, Colour, Image, Mesh, Panel, Projection, Strip, View, from_srgb, render,
};

const SKIN: u32 = 0xd8a88a;
const SOLID: u32 = 0x6d7f94;

/// Where the camera stands: what it looks at, from which side, and how high its view is, m.
#[derive(Clone, Copy)]
pub struct Look {
    pub target: DVec3,
    pub from: DVec3,
    pub height: f64,
}

/// Draws instances, and solids where they stand.
pub fn draw(
    world: &mut World,
    instances: &[InstanceId],
    solids: &[(&Collider, Frame)],
    look: Look,
) -> Result<Image> {
    let (mut positions, mut normals, mut meshes) = (Vec::new(), Vec::new(), Vec::new());
    for &instance in instances {
        world.read_skin_blocking(instance, &mut positions, &mut normals)?;
        let surface = Surface {
            positions: positions.clone(),
            triangles: world.instance(instance)?.avatar().triangles.clone(),
        };
        meshes.push(Mesh::new(surface, from_srgb(SKIN)));
    }
    let solid = |(collider, frame): &(&Collider, Frame)| {
        Mesh::collider(&collider.shape, frame, look.height, from_srgb(SOLID))
    };
    meshes.extend(solids.iter().map(solid));
    let camera = Camera {
        eye: look.target + 4.0 * look.height * look.from.normalize(),
        target: look.target,
        up: world.up().direction(),
        projection: Projection::Orthographic(look.height),
    };
    let mut view = View::new(camera, 300, 320);
    view.supersampling = 2;
    Ok(render(&meshes, &view))
}

/// Writes captioned pictures beside each other.
pub fn write(pictures: Vec<(String, Image)>, path: &Path) -> Result<()> {
    let background: Colour = from_srgb(0xf4f2ee);
    let mut strip = Strip::default();
    let panel = |(caption, image)| Panel { image, caption };
    strip.panels.extend(pictures.into_iter().map(panel));
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(|e| supple::Error::io(folder, e))?;
    }
    strip.compose(background).write_png(path)?;
    println!("{}", path.display());
    Ok(())
}
