//! A grab: springs between a patch of the skin and the cursor, together as stiff as one.

use super::pick::Hit;
use crate::draw::{Camera, Ray, Solid};
use crate::stage::Stage;
use glam::DVec3;
use supple::Result;
use supple::sim::SkinSpring;

/// A vertex of the patch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    vertex: usize,
    /// Its part of the stiffness; all together are 1.
    share: f64,
    /// Where it was taken hold of, m.
    start: DVec3,
}

/// What is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Grab {
    patch: Vec<Held>,
    /// Where the cursor took hold, m.
    start: DVec3,
    /// Where it is, m.
    cursor: DVec3,
    /// From the eye along the view, m: the cursor moves across it.
    depth: f64,
}

/// Radius of the patch, and the longest that the cursor leads, in sizes of the character.
const PATCH: f64 = 0.025;
const LEASH: f64 = 0.6;
/// Vertices of the patch at most.
const MOST: usize = 24;

impl Grab {
    /// Takes hold of what the cursor is over, of a character of this size, m.
    pub fn new(hit: &Hit, camera: &Camera, stage: &Stage, size: f64) -> Self {
        let shown = &stage.shown;
        let held = |vertex: usize| {
            let start = shown.positions[vertex];
            let away = start.distance(shown.positions[hit.vertex]) / (PATCH * size);
            // What faces elsewhere is another side of a thin thing.
            let faces = vertex == hit.vertex || shown.normals[vertex].dot(hit.normal) > 0.3;
            let share = (1.0 - away * away).max(0.0).powi(2);
            (faces && share > 0.0).then_some(Held {
                vertex,
                share,
                start,
            })
        };
        let mut patch: Vec<Held> = (0..shown.positions.len()).filter_map(held).collect();
        patch.sort_by(|a, b| b.share.total_cmp(&a.share));
        patch.truncate(MOST);
        let sum: f64 = patch.iter().map(|held| held.share).sum();
        patch.iter_mut().for_each(|held| held.share /= sum);
        Self {
            patch,
            start: hit.point,
            cursor: hit.point,
            depth: (hit.point - camera.eye()).dot(-camera.axes().z_axis),
        }
    }

    /// Follows the cursor's `ray`, across the view.
    pub fn follow(&mut self, ray: &Ray, camera: &Camera) {
        let along = ray.direction.dot(-camera.axes().z_axis);
        self.cursor = ray.at(self.depth / along);
    }

    /// Goes away from the eye by this, m.
    pub fn push(&mut self, by: f64) {
        self.depth = (self.depth + by).max(0.01);
    }

    /// Where the patch is and where it is drawn to, m.
    fn ends(&self, stage: &Stage, size: f64) -> [DVec3; 2] {
        let mean = |place: &dyn Fn(&Held) -> DVec3| -> DVec3 {
            self.patch.iter().map(|held| held.share * place(held)).sum()
        };
        let at = mean(&|held| stage.shown.positions[held.vertex]);
        let wanted = mean(&|held| held.start) + self.cursor - self.start;
        [at, at + (wanted - at).clamp_length_max(LEASH * size)]
    }

    /// Says it to the world for the steps that follow, with `stiffness` in all, N/m.
    ///
    /// # Errors
    /// None: the vertices are there.
    pub fn hold(&self, stage: &mut Stage, stiffness: f64, size: f64) -> Result<()> {
        let avatar = stage.character.avatar.clone();
        let [_, to] = self.ends(stage, size);
        let middle: DVec3 = self.patch.iter().map(|held| held.share * held.start).sum();
        let spring = |held: &Held| {
            let place = to + held.start - middle;
            SkinSpring::new(&avatar, held.vertex, place, stiffness * held.share)
        };
        let springs: Result<Vec<_>> = self.patch.iter().map(spring).collect();
        stage.character_mut()?.pull_skin(&springs?);
        Ok(())
    }

    /// Lets go.
    ///
    /// # Errors
    /// None: the character stands there.
    pub fn let_go(stage: &mut Stage) -> Result<()> {
        stage.character_mut()?.pull_skin(&[]);
        Ok(())
    }

    /// The force on the skin, N.
    pub fn force(&self, stage: &Stage, stiffness: f64, size: f64) -> f64 {
        let [at, to] = self.ends(stage, size);
        stiffness * at.distance(to)
    }

    /// The force as an arrow to the cursor, and the place that is held.
    pub fn solids(&self, stage: &Stage, size: f64, out: &mut Vec<Solid>) {
        let [at, to] = self.ends(stage, size);
        out.push(Solid::dot(at, 0.006 * size, ARROW));
        if at.distance(to) > 0.01 * size {
            out.push(Solid::arrow(at, to, 0.012 * size, ARROW));
        }
    }

    /// Middle of the arrow, m, for its label.
    pub fn label_place(&self, stage: &Stage, size: f64) -> DVec3 {
        let [at, to] = self.ends(stage, size);
        0.5 * (at + to)
    }
}

/// Linear red, green, blue.
const ARROW: [f32; 3] = [0.02, 0.35, 0.75];
