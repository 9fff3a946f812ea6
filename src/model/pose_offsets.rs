//! Offsets of the reference shape's skin that a host gives from step to step, in addition to pose blend shapes.

use super::Avatar;
use crate::{Error, Result};
use glam::{DVec3, Vec3};

/// u: displacements of the skin's vertices in the reference shape, m. What a host's own model of the pose adds to x̄,
/// be it a network, corrective shapes or morph targets; none at first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseOffsets {
    vectors: Vec<[f32; 3]>,
    longest: f64,
}

impl PoseOffsets {
    /// Copies `offsets`, one for each of [`Avatar::offset_vertices`] of `avatar`; an empty list takes them away.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a wrong count, of an offset that is not finite or longer than the skin is large, and of an
    /// avatar without [`Avatar::pose_extension`]. The offsets stay what they were.
    pub fn set(&mut self, avatar: &Avatar, offsets: &[[f32; 3]]) -> Result<()> {
        let longest = OffsetLimits::new(avatar).check(offsets)?;
        self.vectors.clear();
        self.vectors.extend_from_slice(offsets);
        self.longest = longest;
        Ok(())
    }

    /// One for each vertex, or nothing.
    pub fn as_slice(&self) -> &[[f32; 3]] {
        &self.vectors
    }

    /// Length of the longest, m.
    pub fn longest(&self) -> f64 {
        self.longest
    }
}

impl Avatar {
    /// Skin vertices that may have offsets: the first of [`Avatar::skin`], all but those of bodies.
    pub fn offset_vertices(&self) -> usize {
        self.body_vertices(0).start
    }

    /// Whether the tissue knows how to follow offsets of the skin.
    pub(crate) fn is_extended(&self) -> bool {
        self.pose_extension.len() == self.cubature.len()
    }
}

/// Which offsets an avatar takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OffsetLimits {
    /// How many; none where its tissue could not follow.
    vertices: Option<usize>,
    /// How long, m: what is longer was said in another unit.
    longest: f32,
}

impl OffsetLimits {
    pub fn new(avatar: &Avatar) -> Self {
        let vertices = avatar.offset_vertices();
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let positions = avatar.skin.position[..vertices].iter();
        let [low, high] = positions.fold(none, |[low, high], x| [low.min(*x), high.max(*x)]);
        Self {
            vertices: avatar.is_extended().then_some(vertices),
            longest: (high - low).max_element() as f32,
        }
    }

    /// The length of the longest of `offsets`, m; 0 of none.
    pub fn check(&self, offsets: &[[f32; 3]]) -> Result<f64> {
        let fail = |field: String, problem: String| Err(Error::invalid(field, problem));
        let (all, count) = ("pose_offsets", offsets.len());
        match self.vertices {
            _ if count == 0 => return Ok(0.0),
            None => {
                let problem = "the avatar does not say how its tissue follows them: bake the character again; a \
                    full space, and one of all tets, takes none";
                return fail(all.into(), problem.into());
            }
            Some(vertices) if vertices != count => {
                let problem = format!(
                    "{count} given for {vertices} vertices of the avatar's skin: give one for each"
                );
                return fail(all.into(), problem);
            }
            Some(_) => {}
        }
        let squares = || offsets.iter().map(|u| Vec3::from(*u).length_squared());
        let most = self.longest * self.longest;
        if let Some(v) = squares().position(|square| square.is_nan() || square > most) {
            let (u, longest) = (offsets[v], self.longest);
            let problem = format!(
                "{u:?} is no offset of a skin {longest:.3} m large: give finite metres, in the axes of the bind pose"
            );
            return fail(format!("{all}[{v}]"), problem);
        }
        Ok(f64::from(squares().fold(0.0, f32::max)).sqrt())
    }
}
