//! What a recipe leaves open, chosen from the body: how many handles, and how stiff the tissue is.

use super::handles::HandleRegion;
use super::softness::Softness;
use crate::body::Body;
use crate::softness::Person;
use glam::DVec3;
use supple::material::{Material, StableNeoHookean};
use supple::model::SkinWeight;

/// Spacing of automatic handles in the softest part, relative to the layer's depth there: the basis then
/// follows the slowest ways in which the layer can sway.
const SPACING: f64 = 1.8;
/// How far softness draws them: at 1 a calf, half as deep as a belly, had two or three.
const SOFT: f64 = 0.6;
/// So many automatic handles at least and at most: 100 handles and 24 bones step in real time on one core.
const HANDLES: (usize, usize) = (60, 100);

/// How much denser handles stand on a person's breasts, belly, buttocks and calves: by depth alone the sample body has three on each, and
/// a thigh nine.
const DRAWN: f64 = 1.15;

/// Where handles of a person are drawn to besides what is soft.
pub(crate) fn drawn(body: &Body) -> Vec<f64> {
    let Some(person) = Person::of(body) else {
        return Vec::new();
    };
    let skin = body.skin.positions.iter().zip(body.skinning.iter());
    let at_vertex = |(place, bones): (&DVec3, &[SkinWeight])| {
        let [breast, belly, buttock, _, calf] = person.shares(*place, bones);
        1.0 + (DRAWN - 1.0) * (breast + belly + buttock + calf)
    };
    skin.map(at_vertex).collect()
}

/// Handles over what is soft, spaced by the layer's depth.
pub(crate) fn handle_region(softness: &Softness) -> HandleRegion {
    let spacing = SPACING * softness.deep;
    let count = softness.soft_area / (spacing * spacing);
    let (least, most) = HANDLES;
    HandleRegion {
        // NaN counts as the least.
        count: Some((count.round() as usize).clamp(least, most)),
        soft: SOFT,
        ..HandleRegion::default()
    }
}

/// A brisk shake, m/s²: ±5 cm at 3 Hz.
const SHAKE: f64 = 18.0;
/// How far such a shake shears the deepest part of the layer, on average over its depth.
const SHEAR: f64 = 0.2;
/// How far it moves it at most, m.
const SWAY: f64 = 0.012;
/// How much farther a layer sways than a plate of its depth: it bulges around a bone, and is seen at its loosest place
/// (a fifth more than the 2.3 to 3 on two people, a toy and a hand whose rows did not keep the sway).
const ROUND: f64 = 3.0;
/// Poisson's ratio of automatic tissue.
const POISSONS_RATIO: f64 = 0.4;

/// Tissue that sways visibly: a plate of depth t on a rigid bone that is shaken at a shears by ρ a t/(2 G) on average
/// and moves by ρ a t²/(2 G) at its surface; G is the least that keeps both, times [`ROUND`], below their limits.
/// Young's modulus 2 (1 + ν) G then lies between fat's and relaxed muscle's for a person (14 kPa under 45 mm) and is
/// lower for a hand alone, whose thin layer would not be seen to move at all.
pub(crate) fn material(softness: &Softness, density: f64) -> Material {
    let depth = if softness.deep.is_finite() && softness.deep > 0.0 {
        softness.deep
    } else {
        0.01
    };
    let load = ROUND * density * SHAKE * depth;
    let shear_modulus = (load / (2.0 * SHEAR)).max(load * depth / (2.0 * SWAY));
    // Two digits: a figure that people can read and repeat.
    let youngs_modulus = 2.0 * (1.0 + POISSONS_RATIO) * shear_modulus;
    let digit = 10f64.powf(youngs_modulus.log10().floor() - 1.0);
    Material::StableNeoHookean(StableNeoHookean {
        youngs_modulus: (youngs_modulus / digit).round() * digit,
        poissons_ratio: POISSONS_RATIO,
    })
}
