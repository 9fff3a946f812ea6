//! Caps, orientation, cavities, and the counts of what was found.

use super::SoundSkin;
use crate::Limb;
use crate::mesh::report::SkinReport;
use glam::DVec3;
use supple::collider::Shape;
use supple::model::Surface;

/// A capsule along x around (0.03, 0, 0), bent, so that no two facets lie in one plane.
fn finger() -> Surface {
    let capsule = Shape::Capsule {
        radius: 0.008,
        half_length: 0.03,
    };
    let mut surface = capsule.sampled(600).unwrap();
    for p in &mut surface.positions {
        *p = DVec3::new(0.03 + p.z, p.x + 3.0 * p.z * p.z, p.y + 20.0 * p.z * p.x);
    }
    surface
}

#[test]
fn caps_close_the_cut_ends() {
    let skin = Limb::S.body().unwrap().skin;
    assert!(!skin.is_closed());
    let sound = SoundSkin::new(&skin).unwrap();
    assert!(sound.surface.is_closed());
    assert_eq!(sound.report.holes.len(), 2);
    assert_eq!(sound.surface.positions.len(), skin.positions.len() + 2);
    let rims = sound.held.iter().filter(|held| **held).count();
    assert_eq!(rims, sound.rims.iter().map(Vec::len).sum::<usize>());
    for (h, hole) in sound.report.holes.iter().enumerate() {
        assert_eq!(sound.cap(h).triangles.len(), hole.edges);
    }
    let again = SoundSkin::new(&sound.surface).unwrap();
    assert_eq!(again.surface, sound.surface);
    assert_eq!(again.report.turned_triangles, 0);
}

#[test]
fn what_looks_inward_is_turned_but_cavities_stay() {
    let skin = finger();
    let mut other = skin.clone();
    other.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let sound = SoundSkin::new(&other).unwrap();
    assert!(sound.surface.volume() > 0.0 && sound.surface.is_closed());
    assert_eq!(sound.report.turned_triangles, skin.triangles.len());
    assert_eq!(sound.oriented, sound.surface.triangles);
    // A few only.
    let mut mixed = skin.clone();
    for t in [3, 57, 200, 201] {
        mixed.triangles[t].swap(1, 2);
    }
    let sound = SoundSkin::new(&mixed).unwrap();
    assert_eq!(sound.report.turned_triangles, 4);
    assert!(sound.surface.is_closed() && sound.report.holes.is_empty());
    // A small copy inside, looking inward: a cavity.
    let middle = DVec3::new(0.03, 0.0, 0.0);
    let small = |p: &DVec3| middle + 0.3 * (*p - middle);
    let shift = skin.positions.len() as u32;
    let mut hollow = skin.clone();
    hollow.positions.extend(skin.positions.iter().map(small));
    let inner = skin.triangles.iter().map(|t| t.map(|v| v + shift));
    hollow.triangles.extend(inner.map(|[a, b, c]| [a, c, b]));
    let sound = SoundSkin::new(&hollow).unwrap();
    assert_eq!((sound.report.parts, sound.report.turned_triangles), (2, 0));
    // Outside the other one it is a body that looks the wrong way.
    for p in &mut hollow.positions[skin.positions.len()..] {
        p.y += 1.0;
    }
    let sound = SoundSkin::new(&hollow).unwrap();
    assert_eq!(sound.report.turned_triangles, skin.triangles.len());
}

#[test]
fn faults_are_counted() {
    let mut skin = finger();
    let sound = SoundSkin::new(&skin).unwrap();
    assert_eq!(
        sound.full_report(),
        SkinReport {
            vertices: skin.positions.len(),
            triangles: skin.triangles.len(),
            parts: 1,
            ..SkinReport::default()
        }
    );
    let [a, b, c] = skin.triangles[100];
    skin.triangles.extend([[b, c, a], [a, a, b]]);
    skin.positions.push(DVec3::ONE);
    // A fin on an edge.
    let tip = skin.positions.len() as u32;
    skin.positions.push(skin.positions[a as usize] + DVec3::Y);
    skin.triangles.push([b, a, tip]);
    let report = SoundSkin::new(&skin).unwrap().full_report();
    assert_eq!(report.duplicate_triangles, 1);
    assert_eq!(report.degenerate_triangles, 1);
    assert_eq!(report.isolated_vertices, 1);
    assert_eq!(report.non_manifold_edges, 1);
    skin.positions[0].x = f64::NAN;
    assert!(SoundSkin::new(&skin).is_err());
    assert!(SoundSkin::new(&Surface::default()).is_err());
}

#[test]
fn two_fingers_that_cross_cut_each_other() {
    let skin = finger();
    let mut crossed = skin.clone();
    let shift = skin.positions.len() as u32;
    let place = |p: &DVec3| DVec3::new(0.04 + p.y, p.x - 0.04, p.z);
    crossed.positions.extend(skin.positions.iter().map(place));
    let other = skin.triangles.iter().map(|t| t.map(|v| v + shift));
    crossed.triangles.extend(other.map(|[a, b, c]| [a, c, b]));
    let report = SoundSkin::new(&crossed).unwrap().full_report();
    assert!(report.self_intersections > 50, "{report}");
    assert_eq!(report.parts, 2);
}
