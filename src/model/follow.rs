//! From a host's joint matrices to frames of bones, and back. Nothing here allocates where the output has room.

use super::{Frame, JointList, Skeleton};
use crate::math::symmetric_eigen;
use crate::{Error, Result};
use glam::{DAffine3, DMat3, DMat4, DVec3, Mat4};

/// A bone may be stretched by this much relative to its bind pose: far more than f32 rounds.
const SCALE_TOLERANCE: f64 = 1e-3;

/// The last row of an affine matrix may miss 0 0 0 1 by this much.
const LAST_ROW_TOLERANCE: f64 = 1e-5;

/// What a list of matrices moves.
struct Source<'a> {
    list: &'a JointList,
    /// The skin whose joints the matrices are of; none where they are those of the list itself.
    skin: Option<usize>,
    matrices: &'a [Mat4],
}

impl JointList {
    /// A frame for each bone from the world matrices of the host's joints, one for each of [`JointList::joints`] in that
    /// order (column-major, m): \[R | c\] = W F⁻¹, made orthonormal by its polar factor. `out` gets [`JointList::bones`]
    /// frames. A bone that no joint is moves with its parent; bones above all that joints are move with the first of those.
    /// Matrices of joints that ride on a bone are not read.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a wrong number of matrices, and of a matrix that is not finite, not affine, mirrored, or
    /// scaled or sheared by more than 0.1 % relative to the bind pose, naming the joint, the value and the cure; `out` stays
    /// as it is then.
    pub fn frames_from_world(
        &self,
        skeleton: &Skeleton,
        world: &[Mat4],
        out: &mut Vec<Frame>,
    ) -> Result<()> {
        let source = Source {
            list: self,
            skin: None,
            matrices: world,
        };
        source.frames(skeleton, out)
    }

    /// The same from the skinning matrices S = W · inverse bind of skin `skin`, one for each of its joints in the file's
    /// order. Bones that the skin does not have move with their parents.
    ///
    /// # Errors
    /// As [`JointList::frames_from_world`], and of a skin that is not there or drives nothing.
    pub fn frames_from_skinning(
        &self,
        skeleton: &Skeleton,
        skin: usize,
        matrices: &[Mat4],
        out: &mut Vec<Frame>,
    ) -> Result<()> {
        self.check_skin(skin)?;
        let source = Source {
            list: self,
            skin: Some(skin),
            matrices,
        };
        source.frames(skeleton, out)
    }

    /// The world matrices W = \[R | c\] F of all joints, in the list's order, from frames of bones (those of bodies after
    /// them are passed over).
    ///
    /// # Errors
    /// [`Error::Invalid`] of fewer frames than bones; `out` stays as it is then.
    pub fn joint_matrices(&self, frames: &[Frame], out: &mut Vec<Mat4>) -> Result<()> {
        self.check_frames(frames)?;
        out.clear();
        out.extend((0..self.len()).map(|j| DMat4::from(self.world(j, frames)).as_mat4()));
        Ok(())
    }

    /// The skinning matrices S = W · inverse bind of skin `skin` from frames of bones: what a host's own skinning takes.
    ///
    /// # Errors
    /// As [`JointList::joint_matrices`], and of a skin that is not there or drives nothing.
    pub fn skinning_matrices(
        &self,
        skin: usize,
        frames: &[Frame],
        out: &mut Vec<Mat4>,
    ) -> Result<()> {
        self.check_skin(skin)?;
        self.check_frames(frames)?;
        let found = &self.skins()[skin];
        let pairs = found.joints.iter().zip(&found.inverse_binds);
        let matrix = |(&j, back): (&u32, &DAffine3)| self.world(j as usize, frames) * *back;
        out.clear();
        out.extend(pairs.map(|pair| DMat4::from(matrix(pair)).as_mat4()));
        Ok(())
    }

    fn world(&self, j: usize, frames: &[Frame]) -> DAffine3 {
        let joint = &self.joints()[j];
        affine(&frames[joint.bone.bone()]) * joint.bind
    }

    fn check_frames(&self, frames: &[Frame]) -> Result<()> {
        if frames.len() >= self.bones() {
            return Ok(());
        }
        let problem = format!("{} for {} bones", frames.len(), self.bones());
        Err(Error::invalid("frames", problem))
    }

    fn check_skin(&self, skin: usize) -> Result<()> {
        let problem = match self.skins().get(skin) {
            Some(found) if !found.joints.is_empty() => return Ok(()),
            Some(_) => format!("{skin} drives nothing that the file's scene shows"),
            None => format!("{skin} is not there: the file has {}", self.skins().len()),
        };
        Err(Error::invalid("skin", problem))
    }
}

impl Source<'_> {
    /// The frames of all bones.
    fn frames(&self, skeleton: &Skeleton, out: &mut Vec<Frame>) -> Result<()> {
        let bones = self.list.bones();
        let place = |bone: usize| self.list.place_of(bone, self.skin);
        let count = (self.skin).map_or(self.list.len(), |s| self.list.skins()[s].joints.len());
        if self.matrices.len() != count {
            let order = match self.skin {
                None => "the order of the avatar's joints",
                Some(_) => "the order of the skin's joints in the file",
            };
            let given = self.matrices.len();
            let problem =
                format!("{given} matrices for {count} joints: give one for each, in {order}");
            return Err(Error::invalid(self.field(), problem));
        }
        let found = skeleton.len().min(skeleton.parents.len());
        if found < bones {
            let problem =
                format!("{found} bones; the joints are those of {bones}: give the avatar's own");
            return Err(Error::invalid("skeleton", problem));
        }
        let first = (0..bones).find_map(|bone| Some((bone, place(bone)?)));
        let Some((first_bone, first)) = first else {
            let problem = "no joint is a bone: nothing is driven";
            return Err(Error::invalid(self.field(), problem));
        };
        (0..bones)
            .filter_map(place)
            .try_for_each(|k| self.check(k))?;
        let joint = |bone: usize| skeleton.joints[bone];
        out.clear();
        for bone in 0..bones {
            let frame = match (place(bone), skeleton.parents[bone].map(|p| p as usize)) {
                (Some(k), _) => self.frame(k),
                // What moves with another: R = R_p, c = c_p + R_p (J − J_p).
                (None, Some(p)) if p < bone => carried(&out[p], joint(bone) - joint(p)),
                (None, _) => carried(&self.frame(first), joint(bone) - joint(first_bone)),
            };
            out.push(frame);
        }
        Ok(())
    }

    fn field(&self) -> &'static str {
        self.skin.map_or("joints", |_| "skinning")
    }

    /// The joint that matrix `k` is of, and what the matrix makes of the bone's frame: F, or F · inverse bind.
    fn joint(&self, k: usize) -> (usize, DAffine3) {
        let Some(skin) = self.skin else {
            return (k, self.list.joints()[k].bind);
        };
        let skin = &self.list.skins()[skin];
        let j = skin.joints[k] as usize;
        (j, self.list.joints()[j].bind * skin.inverse_binds[k])
    }

    /// \[R | c\] as the matrix has it, with its rounding, scale and shear.
    fn motion(&self, k: usize) -> DAffine3 {
        DAffine3::from_mat4(self.matrices[k].as_dmat4()) * self.joint(k).1.inverse()
    }

    fn frame(&self, k: usize) -> Frame {
        let motion = self.motion(k);
        let mut rotation = motion.matrix3;
        // Newton's iteration for the polar factor, Q ← Q (3 I − QᵀQ)/2, squares what is left each time: 1e-3, 1e-6, 1e-12.
        for _ in 0..3 {
            let metric = rotation.transpose() * rotation;
            rotation *= (DMat3::IDENTITY * 3.0 - metric) * 0.5;
        }
        Frame {
            rotation,
            position: motion.translation,
        }
    }

    /// Whether matrix `k` moves its joint rigidly.
    fn check(&self, k: usize) -> Result<()> {
        let matrix = self.matrices[k].as_dmat4();
        let last = matrix.row(3);
        let problem = if !matrix.is_finite() {
            "holds a value that is not finite: leave this update out".into()
        } else if (last - DMat4::IDENTITY.row(3)).abs().max_element() > LAST_ROW_TOLERANCE {
            let row = last.to_array();
            format!(
                "has the last row {row:?} and not 0, 0, 0, 1: give column-major affine matrices"
            )
        } else {
            let motion = self.motion(k);
            let linear = motion.matrix3;
            let metric = linear.transpose() * linear;
            let off = (metric - DMat3::IDENTITY).to_cols_array();
            let mirrored = linear.determinant() <= 0.0;
            // |σ² − 1| is at most the norm of MᵀM − I: what is near needs no eigenvalues.
            let near = off.iter().map(|e| e * e).sum::<f64>().sqrt() <= SCALE_TOLERANCE;
            match () {
                () if near && !mirrored && motion.is_finite() => return Ok(()),
                () if !motion.is_finite() => "is out of all bounds: keep it nearer".into(),
                () => match not_rigid(metric, mirrored) {
                    Some(problem) => problem,
                    None => return Ok(()),
                },
            }
        };
        let name = &self.list.joints()[self.joint(k).0].name;
        let problem = format!("joint {name:?} {problem}");
        Err(Error::invalid(format!("{}[{k}]", self.field()), problem))
    }
}

/// What is wrong with a motion of MᵀM = `metric`, if anything is.
fn not_rigid(metric: DMat3, mirrored: bool) -> Option<String> {
    let scales = symmetric_eigen(metric).0.max(DVec3::ZERO).map(f64::sqrt);
    let (least, most) = (scales.min_element(), scales.max_element());
    if mirrored {
        let cure = "take the negative (or zero) scale out of the node and of those above it";
        return Some(format!(
            "is mirrored or flat, scaled by {least:.4} to {most:.4}: {cure}"
        ));
    }
    let rigid = 1.0 - SCALE_TOLERANCE..=1.0 + SCALE_TOLERANCE;
    if rigid.contains(&least) && rigid.contains(&most) {
        return None;
    }
    Some(if most - least <= SCALE_TOLERANCE * most {
        format!(
            "is {most:.4} times as large as in its bind pose, and bones are rigid: take that scale out of the node and of \
             those above it, or bake the character that large"
        )
    } else {
        format!(
            "is sheared or scaled by {least:.4} to {most:.4} relative to its bind pose, and bones are rigid: scale no node \
             unevenly"
        )
    })
}

fn affine(frame: &Frame) -> DAffine3 {
    DAffine3 {
        matrix3: frame.rotation,
        translation: frame.position,
    }
}

/// A frame that stands at `offset` of another in the reference shape.
fn carried(frame: &Frame, offset: DVec3) -> Frame {
    Frame {
        rotation: frame.rotation,
        position: frame.transform(offset),
    }
}
