//! A grab: a spring between a vertex of the skin and the cursor.

use super::pick::Hit;
use crate::draw::{Camera, Ray, Solid};
use crate::stage::Stage;
use glam::DVec3;
use supple::Result;
use supple::sim::SkinSpring;

/// What is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grab {
    vertex: usize,
    /// Where the cursor holds it, m.
    place: DVec3,
    /// From the eye along the view, m: the cursor moves across it.
    depth: f64,
    /// From the vertex to where it was taken hold of, m.
    offset: DVec3,
}

/// The longest that the cursor leads, in sizes of the character.
const LEASH: f64 = 0.6;

impl Grab {
    /// Takes hold of what the cursor is over.
    pub fn new(hit: &Hit, camera: &Camera, positions: &[DVec3]) -> Self {
        let vertex = positions[hit.vertex];
        Self {
            vertex: hit.vertex,
            place: vertex,
            depth: (hit.point - camera.eye()).dot(-camera.axes().z_axis),
            offset: vertex - hit.point,
        }
    }

    /// Follows the cursor's `ray`, across the view.
    pub fn follow(&mut self, ray: &Ray, camera: &Camera) {
        let along = ray.direction.dot(-camera.axes().z_axis);
        self.place = ray.at(self.depth / along) + self.offset;
    }

    /// Comes nearer to the eye by this, m.
    pub fn come_near(&mut self, by: f64) {
        self.depth = (self.depth - by).max(0.01);
    }

    /// Says it to the world for the steps that follow, with a spring of `stiffness`, N/m.
    ///
    /// # Errors
    /// None: the vertex is there.
    pub fn hold(&self, stage: &mut Stage, stiffness: f64) -> Result<()> {
        let at = stage.shown.positions[self.vertex];
        let [low, high] = stage.bounds();
        let place = at + (self.place - at).clamp_length_max(LEASH * (high - low).length());
        let avatar = stage.character.avatar.clone();
        let spring = SkinSpring::new(&avatar, self.vertex, place, stiffness)?;
        stage.instance_mut()?.skin_springs = vec![spring];
        Ok(())
    }

    /// Lets go.
    ///
    /// # Errors
    /// None: the character stands there.
    pub fn let_go(stage: &mut Stage) -> Result<()> {
        stage.instance_mut()?.skin_springs.clear();
        Ok(())
    }

    /// The force on the skin, N, where a spring holds it.
    pub fn force(stage: &Stage) -> Option<(DVec3, DVec3)> {
        let instance = stage.world.instance(stage.me).ok()?.instance();
        let spring = instance.skin_springs.first()?;
        let at = stage.shown.positions[spring.vertex()];
        Some((at, spring.stiffness * (spring.place - at)))
    }

    /// The force as an arrow to where the cursor is, and the point that is held.
    pub fn solids(stage: &Stage, size: f64, out: &mut Vec<Solid>) {
        let instance = stage.world.instance(stage.me).map(|c| c.instance());
        let Some(spring) = instance.ok().and_then(|i| i.skin_springs.first()) else {
            return;
        };
        let at = stage.shown.positions[spring.vertex()];
        out.push(Solid::dot(at, 0.006 * size, ARROW));
        if at.distance(spring.place) > 0.01 * size {
            out.push(Solid::arrow(at, spring.place, 0.012 * size, ARROW));
        }
    }
}

/// Linear red, green, blue.
const ARROW: [f32; 3] = [0.02, 0.35, 0.75];
