//! Mass and second moments of the bones.

use super::core_volume::core_samples;
use super::loads::BoneLoads;
use crate::body::Body;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use supple::internal::math::Rows;
use supple::model::{BoneMass, SkinWeight, Surface};

/// Where the bones' mass came from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoneMassReport {
    /// Mass of each bone, kg.
    pub masses: Vec<f64>,
    /// Their sum, kg.
    pub total: f64,
    /// Bones whose mass is that of their closed surface; the core is shared out over the others.
    pub from_surfaces: usize,
    /// Bones that came out lighter than 1 % of the mean and got a ball of that mass at the joint.
    pub raised: usize,
}

/// A bone below this share of the mean mass is raised to it: its DoFs need some inertia.
const LEAST_SHARE: f64 = 0.01;

/// The mass of every bone of `body`: of its closed surface where it has one, and for the others the
/// core (inside the skin, outside the layer and those surfaces) shared out by the weights of the
/// nearest node that a bone holds. `density` in kg/m³. Bones on and below which only attached parts hang, or nothing, have
/// none: what drives the others carries them.
pub fn bone_masses(
    body: &Body,
    node_skinning: &Rows<SkinWeight>,
    density: f64,
) -> (Vec<BoneMass>, BoneMassReport) {
    let joints = &body.skeleton.joints;
    let closed = |j: usize| body.bone_surfaces.get(j).filter(|s| s.is_closed());
    let mut masses: Vec<BoneMass> = (joints.iter().enumerate())
        .map(|(j, &joint)| match closed(j) {
            Some(surface) => BoneMass::of_surface(surface, joint, density),
            None => BoneMass::NONE,
        })
        .collect();
    let from_surfaces = (0..joints.len()).filter(|&j| closed(j).is_some()).count();
    if from_surfaces < joints.len() {
        let known: Vec<&Surface> = (0..joints.len()).filter_map(closed).collect();
        for sample in core_samples(body, &known) {
            let row = node_skinning.row(sample.nearest_node as usize);
            // What lies around a bone of known surface is not its own.
            let open: f64 = (row.iter())
                .filter(|w| closed(w.bone as usize).is_none())
                .map(|w| w.weight)
                .sum();
            for w in row.iter().filter(|w| closed(w.bone as usize).is_none()) {
                let bone = w.bone as usize;
                let mass = density * sample.volume * w.weight / open;
                masses[bone].add_point(sample.position - joints[bone], 1.0, mass);
            }
        }
    }
    let total: f64 = masses.iter().map(BoneMass::mass).sum();
    let loaded = BoneLoads::of(body).mass;
    let count = loaded.iter().filter(|l| **l).count();
    // Nothing at all is known: a litre's worth of density keeps the system regular.
    let mean = if total > 0.0 { total } else { density * 1e-3 } / count as f64;
    let mut raised = 0;
    for (bone, _) in masses.iter_mut().zip(loaded).filter(|(_, loaded)| *loaded) {
        if bone.mass() < LEAST_SHARE * mean {
            *bone = ball(LEAST_SHARE * mean, density);
            raised += 1;
        }
    }
    let report = BoneMassReport {
        masses: masses.iter().map(BoneMass::mass).collect(),
        total: masses.iter().map(BoneMass::mass).sum(),
        from_surfaces,
        raised,
    };
    (masses, report)
}

/// A ball about the joint: ∫ ρ y yᵀ = m r²/5 I.
fn ball(mass: f64, density: f64) -> BoneMass {
    let radius = (3.0 * mass / (4.0 * std::f64::consts::PI * density)).cbrt();
    BoneMass::centred(mass, DVec3::splat(mass * radius * radius / 5.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limb;
    use approx::assert_relative_eq;

    /// A box from `low` to `high`.
    fn block(low: DVec3, high: DVec3) -> Surface {
        let positions = (0..8)
            .map(|c| {
                let pick = |bit: usize, a: f64, b: f64| if c & bit == 0 { a } else { b };
                DVec3::new(
                    pick(1, low.x, high.x),
                    pick(2, low.y, high.y),
                    pick(4, low.z, high.z),
                )
            })
            .collect();
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles = quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect();
        Surface {
            positions,
            triangles,
        }
    }

    #[test]
    fn a_block_has_its_textbook_moments() {
        let (low, high) = (DVec3::new(-0.1, 0.2, 0.0), DVec3::new(0.3, 0.5, 0.2));
        let surface = block(low, high);
        assert!(surface.is_closed() && surface.volume() > 0.0);
        let joint = DVec3::new(0.05, 0.1, -0.2);
        let found = BoneMass::of_surface(&surface, joint, 1100.0).second_moment;
        let (size, centre) = (high - low, (low + high) / 2.0 - joint);
        let mass = 1100.0 * size.element_product();
        for i in 0..3 {
            for j in 0..3 {
                let own = if i == j {
                    mass * size[i] * size[i] / 12.0
                } else {
                    0.0
                };
                let expected = own + mass * centre[i] * centre[j];
                assert_relative_eq!(found[i][j], expected, epsilon = 1e-12, max_relative = 1e-12);
            }
            assert_relative_eq!(found[i][3], mass * centre[i], max_relative = 1e-12);
            assert_relative_eq!(found[3][i], mass * centre[i], max_relative = 1e-12);
        }
        assert_relative_eq!(found[3][3], mass, max_relative = 1e-12);
    }

    #[test]
    fn the_core_of_a_limb_is_its_bone() {
        let limb = Limb::S;
        let body = limb.body().unwrap();
        let whole = SkinWeight {
            bone: 0,
            weight: 1.0,
        };
        let nodes: Rows<SkinWeight> = body.layer.mesh.nodes.iter().map(|_| [whole]).collect();
        let (masses, report) = bone_masses(&body, &nodes, 1000.0);
        let n = limb.sectors as f64;
        let polygon = 0.5 * n * (std::f64::consts::TAU / n).sin() * limb.inner_radius.powi(2);
        // Sampled: half a cell of the surface either way.
        assert_relative_eq!(
            report.total,
            1000.0 * polygon * limb.length,
            max_relative = 0.02
        );
        assert_relative_eq!(
            masses[0].second_moment[0][0],
            report.total * limb.length.powi(2) / 12.0,
            max_relative = 0.03
        );
        assert_eq!((report.from_surfaces, report.raised), (0, 0));
    }

    #[test]
    fn a_bone_without_mass_is_raised() {
        let mut body = Limb::S.body().unwrap();
        body.skeleton.names.push("tip".into());
        body.skeleton.parents.push(Some(0));
        body.skeleton.joints.push(DVec3::X);
        let whole = SkinWeight {
            bone: 0,
            weight: 1.0,
        };
        // It moves one vertex, and no node.
        let tip = SkinWeight {
            bone: 1,
            weight: 1.0,
        };
        let rows = body.skinning.iter().enumerate();
        body.skinning = rows
            .map(|(v, row)| if v == 0 { vec![tip] } else { row.to_vec() })
            .collect();
        let nodes: Rows<SkinWeight> = body.layer.mesh.nodes.iter().map(|_| [whole]).collect();
        let (masses, report) = bone_masses(&body, &nodes, 1000.0);
        assert_eq!(report.raised, 1);
        assert!(masses[1].second_moment[3][3] > 0.0 && masses[1].second_moment[0][0] > 0.0);
    }
}
