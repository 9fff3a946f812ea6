//! A pin pressed near to handles and away from them.

use super::press::{Pressed, press_along};
use super::skins::{HANDLE, Look, Prop, Skin, skin_strip};
use super::{Bound, Figure, Page, Runner};
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;
use supple::Result;
use supple::collider::Shape;
use supple::material::{Material, StableNeoHookean};
use supple::model::{Avatar, Frame};
use supple::potential::{CpuPotential, Potential};
use supple_bake::math::NearestPoint;
use supple_bake::mesh::ShellOptions;
use supple_bake::{
    HandleCandidates, HandleRegion, Recipe, SparseCholesky, Truncation, bake, full_space,
};
use supple_pictures::{ColourScale, Curves};
use supple_samples::Finger;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "pin_press",
    title: "A pin near to a handle and away from it",
    paper: "figure 16",
    draw,
};

/// Of the pin's round tip, and half the length of its shaft, m.
const PIN: Shape = Shape::Capsule {
    radius: 0.003,
    half_length: 0.012,
};
/// From the pin's middle to its tip, m.
const PIN_LENGTH: f64 = 0.015;
/// How deep it is pressed, m.
const DEPTHS: [f64; 3] = [0.0, 0.001, 0.002];
/// The part of the pad that has many handles, on the skin and under it, and how far apart they stand, m.
const PATCH: [[f64; 3]; 2] = [[0.058, -0.008, -0.03], [0.072, 0.008, -0.001]];
const SPACING: f64 = 0.002;
/// Where the pin goes: from the middle of these handles along the pad towards the tip, m.
const START: f64 = 0.065;
const END: f64 = 0.085;
/// Half the width of that way, m.
const ASIDE: f64 = 0.003;

/// A place of the pin and what came of it.
struct Prick {
    /// To the nearest handle, m.
    distance: f64,
    truth: Pressed,
    reduced: Pressed,
    /// Relative L2 error of the skin's displacement.
    error: f64,
}

fn draw(runner: &Runner) -> Result<Page> {
    let avatar = Arc::new(finger(runner)?);
    let space = Arc::new(full_space(&avatar)?);
    let mut pricks = Vec::new();
    let places = places(&avatar, runner.pick(4, 8));
    for (k, &(vertex, distance)) in places.iter().enumerate() {
        let x = avatar.skin.position[vertex];
        let inward = -normals(&avatar)[vertex];
        let turn = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, inward));
        let frames = DEPTHS.map(|depth| Frame {
            rotation: turn,
            position: x + (depth - PIN_LENGTH) * inward,
        });
        let potential = CpuPotential::new(space.clone(), 1)?;
        let solver = Box::new(SparseCholesky::new(potential.pattern())?);
        let truth = press_along(&space, potential, Some(solver), PIN, &frames)?;
        let potential = CpuPotential::new(avatar.clone(), 1)?;
        let reduced = press_along(&avatar, potential, None, PIN, &frames)?;
        pricks.push(Prick {
            distance,
            error: reduced.relative_error(&truth),
            truth,
            reduced,
        });
        runner.progress("pin press", k + 1, places.len());
    }
    page(runner, &avatar, &pricks)
}

/// The finger: many handles in one part of its pad, few everywhere else.
fn finger(runner: &Runner) -> Result<Avatar> {
    let finger = runner.pick(
        Finger::default(),
        Finger {
            edge_length: 0.0016,
            shell: ShellOptions {
                layers: Some(3),
                ..Finger::default().shell
            },
        },
    );
    let recipe = Recipe {
        material: Some(Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus: 30e3,
            poissons_ratio: 0.4,
        })),
        handles: vec![
            HandleRegion {
                candidates: HandleCandidates::Volume,
                within: Some(PATCH),
                spacing: Some(SPACING),
                ..HandleRegion::default()
            },
            HandleRegion {
                count: Some(30),
                ..HandleRegion::default()
            },
        ],
        // Little is cut off: what is costs accuracy where handles are dense.
        truncation: Truncation {
            enabled: true,
            below: 0.005,
            above: 0.02,
            ..Truncation::OFF
        },
        ..Recipe::default()
    };
    let mut silent = |_: usize| {};
    Ok(bake(&finger.body()?, &recipe, &mut silent)?.0)
}

fn normals(avatar: &Avatar) -> Vec<DVec3> {
    supple::model::Surface {
        positions: avatar.skin.position.clone(),
        triangles: avatar.triangles.clone(),
    }
    .vertex_normals()
}

/// `count` vertices on the pin's way, each with its distance to the nearest handle: the first at a handle in the middle of
/// many, the others evenly up to as far from any as the way goes.
fn places(avatar: &Avatar, count: usize) -> Vec<(usize, f64)> {
    let nearest = NearestPoint::new(&avatar.handles);
    let normals = normals(avatar);
    let way: Vec<(usize, f64)> = (avatar.skin.position.iter().enumerate())
        .filter(|(v, x)| (START..END).contains(&x.x) && x.y.abs() < ASIDE && normals[*v].z < -0.75)
        .map(|(v, x)| (v, nearest.distance(*x)))
        .collect();
    let farthest = way.iter().fold(0.0, |m: f64, p| m.max(p.1));
    let from_start = |v: usize| avatar.skin.position[v].x - START;
    let closest = |k: usize| {
        let wanted = farthest * k as f64 / (count - 1).max(1) as f64;
        // Of handles the one where the way starts.
        let off = |p: &&(usize, f64)| (p.1 - wanted).abs() + 0.01 * from_start(p.0);
        way.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
    };
    (0..count).filter_map(closest).copied().collect()
}

fn page(runner: &Runner, avatar: &Avatar, pricks: &[Prick]) -> Result<Page> {
    let mut page = Page::new(format!(
        "A blunt pin of 6 mm is pressed {:.1} mm into the pad of a finger, along the normal of the skin, bones held, in \
         equilibrium: first in the middle of a patch where handles stand {:.0} mm apart, then ever farther from the nearest \
         handle. The handle basis can dent the skin where handles are as dense as the dent is small. There are {} handles, \
         and the full space has {} nodes that move.",
        1e3 * DEPTHS[DEPTHS.len() - 1],
        1e3 * SPACING,
        avatar.handles.len(),
        (avatar.layer.bone_of_node.iter())
            .filter(|b| b.is_none())
            .count(),
    ));
    let curve = |value: fn(&Prick) -> f64| pricks.iter().map(move |p| (1e3 * p.distance, value(p)));
    page.curves(
        Curves::new(
            "Error of the skin's displacement against the full space",
            "distance of the pin from the nearest handle (mm)",
            "relative L2 error (%)",
        )
        .dots("error", curve(|p| 100.0 * p.error)),
    );
    page.curves(
        Curves::new(
            "Force on the pin",
            "distance of the pin from the nearest handle (mm)",
            "force (N)",
        )
        .dots("handles", curve(|p| p.reduced.force()))
        .dots("full space", curve(|p| p.truth.force())),
    );
    if let (Some(near), Some(far)) = (pricks.first(), pricks.last()) {
        let image = picture(runner, avatar, [near, far]);
        let caption = "the pad from below, handles on the skin in black, the pin not drawn: pressed at a handle, and far \
                       from any";
        page.picture("pins", image, caption);
        page.check(
            "error at a handle among many",
            100.0 * near.error,
            "%",
            Bound::AtMost(50.0),
        );
        page.check(
            "error at a handle by error far from any",
            near.error / far.error,
            "",
            Bound::AtMost(0.5),
        );
    }
    page.check(
        "rank correlation of error and distance",
        rank_correlation(pricks),
        "",
        Bound::AtLeast(0.7),
    );
    Ok(page)
}

/// Spearman's ρ of error and distance.
fn rank_correlation(pricks: &[Prick]) -> f64 {
    let rank = |value: fn(&Prick) -> f64| -> Vec<f64> {
        let below = |p: &Prick| pricks.iter().filter(|o| value(o) < value(p)).count() as f64;
        pricks.iter().map(below).collect()
    };
    let (errors, distances) = (rank(|p| p.error), rank(|p| p.distance));
    let differences = errors.iter().zip(&distances).map(|(a, b)| a - b);
    let squares: f64 = differences.map(|d| d * d).sum();
    let n = pricks.len() as f64;
    1.0 - 6.0 * squares / (n * (n * n - 1.0))
}

fn picture(runner: &Runner, avatar: &Avatar, pricks: [&Prick; 2]) -> supple_pictures::Image {
    let dot = Shape::Sphere { radius: 0.0004 };
    let skin = |caption: String, pressed: &Pressed| {
        let moved = |at: &DVec3| {
            // A handle's dot goes with the skin that it stands on.
            let of = (avatar.skin.position.iter().zip(&pressed.displacement))
                .min_by(|a, b| a.0.distance(*at).total_cmp(&b.0.distance(*at)));
            *at + of.map_or(DVec3::ZERO, |(_, d)| *d)
        };
        let handles = avatar.handles.iter().map(|at| Prop {
            shape: dot.clone(),
            frame: Frame {
                position: moved(at),
                ..Frame::IDENTITY
            },
            colour: HANDLE,
        });
        Skin {
            caption,
            positions: (avatar.skin.position.iter().zip(&pressed.displacement))
                .map(|(x, d)| *x + *d)
                .collect(),
            values: pressed
                .displacement
                .iter()
                .map(|d| 1e3 * d.length())
                .collect(),
            props: handles.collect(),
        }
    };
    let mut skins = Vec::new();
    for prick in pricks {
        let place = format!("{:.1} mm from a handle", 1e3 * prick.distance);
        skins.push(skin(format!("full space, {place}"), &prick.truth));
        let error = format!("handles: {:.0} % error", 100.0 * prick.error);
        skins.push(skin(error, &prick.reduced));
    }
    let look = Look {
        direction: DVec3::new(-0.2, 0.3, 1.0),
        up: DVec3::NEG_Z,
        focus: Some((DVec3::new(0.072, 0.0, -0.006), 0.016)),
        size: [420, 340],
        columns: 2,
        draft: runner.small(),
    };
    let scale = ColourScale::of(skins.iter().flat_map(|s| s.values.clone()));
    skin_strip(avatar, &skins, look, "displacement (mm)", scale)
}
