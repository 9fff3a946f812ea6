//! A basis that knows elasticity, against those that do not.

use super::press::{self, Pressed, limb_recipe, press_full_space, press_with};
use super::skins::{Look, Skin, skin_strip};
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use std::sync::Arc;
use supple::Result;
use supple::collider::Collider;
use supple::internal::cpu::{Basis, min_det_f};
use supple::internal::math::Stopwatch;
use supple::model::{Avatar, State};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation};
use supple_bake::subspace::{Subspace, elastic_extension, harmonic_extension};
use supple_bake::{CubatureRecipe, HandleRegion, Recipe, Truncation, all_tets};
use supple_pictures::ColourScale;
use supple_samples::Sample;
use supple_scene::{AvatarSource, BodyOrigin, BodySource};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "elastic_extension",
    title: "A basis that knows elasticity",
    paper: "",
    draw,
};

/// Harder and harder: below the skin a handle's part is smaller than on it.
const DEPTH_TRUNCATIONS: [Truncation; 3] = [truncation(0.003), truncation(0.01), truncation(0.03)];

const fn truncation(below: f64) -> Truncation {
    Truncation {
        enabled: true,
        below,
        above: 3.0 * below,
        ..Truncation::OFF
    }
}

/// How the handles' values on the skin are carried into the depth.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Extension {
    /// As the biharmonic basis does.
    Biharmonic,
    Harmonic,
    /// Its blocks truncated below the skin too, or not.
    Elastic(Truncation),
}

/// A space that the limb is pressed in.
enum Space {
    Scalar(Arc<Avatar>),
    General(Subspace),
}

impl Extension {
    fn name(self) -> String {
        match self {
            Self::Biharmonic => "biharmonic".into(),
            Self::Harmonic => "harmonic".into(),
            Self::Elastic(depth) if depth.enabled => {
                format!("elastic, below {} left out in the depth too", depth.below)
            }
            Self::Elastic(_) => "elastic".into(),
        }
    }

    fn of(self, avatar: &Arc<Avatar>) -> Result<Space> {
        Ok(match self {
            Self::Biharmonic => Space::Scalar(avatar.clone()),
            Self::Harmonic => Space::Scalar(Arc::new(harmonic_extension(avatar, Truncation::OFF)?)),
            Self::Elastic(depth) => Space::General(elastic_extension(avatar, depth)?),
        })
    }
}

impl Space {
    fn press(&self, depths: &[f64]) -> Result<Pressed> {
        match self {
            Self::Scalar(avatar) => press::press(avatar, depths),
            Self::General(space) => {
                let avatar = space.avatar();
                press_with(avatar, space.reference(1)?, None, depths)
            }
        }
    }

    fn min_det_f(&self, state: &State) -> Result<f64> {
        match self {
            Self::Scalar(avatar) => Ok(min_det_f(avatar, state)),
            Self::General(space) => space.min_det_f(state),
        }
    }

    /// Handles of a cubature point, on average.
    fn entries(&self) -> f64 {
        match self {
            Self::Scalar(avatar) => {
                let rows = &avatar.cubature.basis;
                rows.entries().len() as f64 / rows.len().max(1) as f64
            }
            Self::General(space) => space.entries_per_point(),
        }
    }

    /// Wall-clock time of a step under the press at `depth`, ms.
    fn ms_a_step(&self, depth: f64) -> Result<f64> {
        match self {
            Self::Scalar(avatar) => ms_a_step(avatar, CpuPotential::new(avatar.clone(), 1)?, depth),
            Self::General(space) => {
                let avatar = space.avatar();
                ms_a_step(avatar, space.reference(1)?, depth)
            }
        }
    }
}

/// The median of a few steps with one Newton iteration each.
fn ms_a_step<B: Basis>(avatar: &Avatar, potential: CpuPotential<B>, depth: f64) -> Result<f64> {
    const STEPS: usize = 9;
    let mut simulation = Simulation::new(avatar, potential, Settings::default())?;
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    let (shape, frame) = press::sphere(depth);
    instance.colliders.push(Collider::new(shape, frame));
    let mut times = Vec::new();
    for _ in 0..STEPS {
        times.push(simulation.step_blocking()?.timings.step);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[STEPS / 2])
}

/// The limb with a handle at every skin vertex around the contact.
fn source(runner: &Runner, truncation: Truncation) -> AvatarSource {
    let spread = runner.pick(0.035, 0.055);
    let recipe = Recipe {
        handles: vec![HandleRegion {
            within: Some([[0.1 - spread, -0.045, -0.005], [0.1 + spread, 0.045, 0.045]]),
            ..HandleRegion::default()
        }],
        truncation,
        cubature: CubatureRecipe::default(),
        ..limb_recipe()
    };
    BodySource {
        from: BodyOrigin::Sample {
            sample: Sample::LimbS,
            betas: Vec::new(),
        },
        scale: None,
        up: None,
        bake: Some(recipe),
    }
    .into()
}

/// A space and how the press went in it.
struct Outcome {
    extension: Extension,
    truncated: bool,
    pressed: Pressed,
    error: f64,
    min_det_f: f64,
}

fn draw(runner: &Runner) -> Result<Page> {
    let depths = runner.pick(&[0.0, 0.004, 0.008][..], &[0.0, 0.006, 0.012]);
    let deepest = depths[depths.len() - 1];
    let mut page = Page::new(
        "A handle's column tells how far each point follows it. The biharmonic one is smooth everywhere; it knows \
         nothing of what tissue is. Here its values on the skin are kept, and below the skin they are extended \
         anew: as harmonic functions, or as an elastic body would move whose skin is carried along and whose bones \
         stand still. Then pressed tissue gives way sideways, as Poisson's ratio demands, for which each handle needs \
         a 3×3 block at each node. The press is the bone press on mesh S, in equilibrium, with a handle at every skin \
         vertex around the contact.",
    );
    let mut truth = None;
    let mut outcomes: Vec<Outcome> = Vec::new();
    let mut rows = Vec::new();
    for truncation in [Truncation::OFF, Truncation::default()] {
        let sampled = runner.avatar(&source(runner, truncation))?;
        let whole = match runner.small() {
            true => sampled.clone(),
            false => Arc::new(all_tets(&sampled)?),
        };
        if truth.is_none() {
            truth = Some(press_full_space(&whole, depths)?);
        }
        let Some(truth) = &truth else { continue };
        let mut extensions = vec![
            Extension::Biharmonic,
            Extension::Harmonic,
            Extension::Elastic(Truncation::OFF),
        ];
        if truncation.enabled {
            let depths = runner.pick(&DEPTH_TRUNCATIONS[..1], &DEPTH_TRUNCATIONS);
            extensions.extend(depths.iter().map(|depth| Extension::Elastic(*depth)));
        }
        for extension in extensions {
            let watch = Stopwatch::start();
            let space = extension.of(&sampled)?;
            let made = watch.ms();
            let with_cubature = space.press(depths)?;
            let (entries, ms) = (space.entries(), space.ms_a_step(deepest)?);
            let (pressed, min_det_f) = match runner.small() {
                true => {
                    let least = space.min_det_f(&with_cubature.state)?;
                    (with_cubature.clone(), least)
                }
                false => {
                    let space = extension.of(&whole)?;
                    let pressed = space.press(depths)?;
                    let least = space.min_det_f(&pressed.state)?;
                    (pressed, least)
                }
            };
            let error = pressed.relative_error(truth);
            rows.push(vec![
                extension.name(),
                if truncation.enabled { "yes" } else { "no" }.to_string(),
                format!("{:.1}", 100.0 * error),
                format!("{:.1}", 100.0 * with_cubature.relative_error(truth)),
                format!("{:.2}", pressed.force()),
                format!("{min_det_f:.2}"),
                format!("{entries:.1}"),
                format!("{ms:.2}"),
                format!("{:.0}", made),
            ]);
            outcomes.push(Outcome {
                extension,
                truncated: truncation.enabled,
                pressed,
                error,
                min_det_f,
            });
            runner.progress("elastic extension", outcomes.len(), runner.pick(7, 9));
        }
    }
    let Some(truth) = truth else { return Ok(page) };
    let avatar = runner.avatar(&source(runner, Truncation::OFF))?;
    page.text(format!(
        "{} handles, {} cubature points and {} tets; the full-space solution pushes back with {:.2} N at {:.0} mm.",
        avatar.handles.len(),
        avatar.cubature.len(),
        avatar.layer.mesh.tets.len(),
        truth.force(),
        1e3 * deepest
    ));
    page.table(
        "Error of the skin's displacement (relative L2) against the full space. Truncated: on the skin, as the \
         avatar's own basis. The step has one Newton iteration and the cubature, on the CPU in f64.",
        &[
            "extension",
            "truncated",
            "error, all tets (%)",
            "error, cubature (%)",
            "force (N)",
            "min det F",
            "handles a point",
            "ms a step",
            "made in (ms)",
        ],
        rows,
    );
    pictures(runner, &avatar, &truth, &outcomes, &mut page);
    check(runner, &outcomes, &mut page);
    Ok(page)
}

/// The dents, and where each is off.
fn pictures(
    runner: &Runner,
    avatar: &Avatar,
    truth: &Pressed,
    outcomes: &[Outcome],
    page: &mut Page,
) {
    let shown = |extension: Extension| {
        let found = outcomes
            .iter()
            .find(|o| o.truncated && o.extension == extension);
        found.map(|o| (o.extension.name(), &o.pressed))
    };
    let extensions = [
        Extension::Biharmonic,
        Extension::Harmonic,
        Extension::Elastic(Truncation::OFF),
    ];
    let reduced: Vec<(String, &Pressed)> = extensions.into_iter().filter_map(shown).collect();
    let look = Look {
        direction: DVec3::new(0.3, 1.0, -1.3),
        up: DVec3::Z,
        focus: Some((DVec3::new(0.1, 0.0, 0.022), 0.062)),
        size: [420, 340],
        columns: 2,
        draft: runner.small(),
    };
    let skin = |name: &str, pressed: &Pressed, values: Vec<f64>| Skin {
        caption: name.into(),
        positions: (avatar.skin.position.iter().zip(&pressed.displacement))
            .map(|(x, d)| *x + *d)
            .collect(),
        values,
        props: Vec::new(),
    };
    let length = |d: &DVec3| 1e3 * d.length();
    let moved = |p: &Pressed| -> Vec<f64> { p.displacement.iter().map(length).collect() };
    let mut skins = vec![skin("full space", truth, moved(truth))];
    skins.extend(reduced.iter().map(|(name, p)| skin(name, p, moved(p))));
    let scale = ColourScale::of(skins.iter().flat_map(|s| s.values.clone()));
    page.picture(
        "dents",
        skin_strip(avatar, &skins, look, "displacement (mm)", scale),
        "the pressed limb, sphere not drawn; bases truncated on the skin",
    );
    let off = |p: &Pressed| -> Vec<f64> {
        let pairs = p.displacement.iter().zip(&truth.displacement);
        pairs.map(|(a, b)| 1e3 * a.distance(*b)).collect()
    };
    let skins: Vec<Skin> = reduced
        .iter()
        .map(|(name, p)| skin(name, p, off(p)))
        .collect();
    let scale = ColourScale::of(skins.iter().flat_map(|s| s.values.clone()));
    let look = Look { columns: 3, ..look };
    page.picture(
        "errors",
        skin_strip(
            avatar,
            &skins,
            look,
            "distance from the full space (mm)",
            scale,
        ),
        "how far each is from where the full space puts it",
    );
}

fn check(runner: &Runner, outcomes: &[Outcome], page: &mut Page) {
    let error = |extension: Extension, truncated: bool| {
        let found = outcomes
            .iter()
            .find(|o| (o.extension, o.truncated) == (extension, truncated));
        found.map_or(f64::NAN, |o| 100.0 * o.error)
    };
    let elastic = Extension::Elastic(Truncation::OFF);
    for truncated in [false, true] {
        let told = if truncated {
            "truncated"
        } else {
            "untruncated"
        };
        let [own, harmonic, elastic] = [Extension::Biharmonic, Extension::Harmonic, elastic]
            .map(|extension| error(extension, truncated));
        let most = runner.pick(40.0, if truncated { 15.0 } else { 12.0 });
        let what = format!("error of the elastic extension, {told}");
        page.check(what, elastic, "%", Bound::AtMost(most));
        let what = format!("elastic error by biharmonic error, {told}");
        page.check(
            what,
            elastic / own,
            "",
            Bound::AtMost(runner.pick(0.9, 0.6)),
        );
        let what = format!("elastic error by harmonic error, {told}");
        page.check(
            what,
            elastic / harmonic,
            "",
            Bound::AtMost(runner.pick(0.9, 0.8)),
        );
    }
    let least = outcomes
        .iter()
        .filter(|o| matches!(o.extension, Extension::Elastic(_)));
    let least = least.fold(f64::INFINITY, |m, o| m.min(o.min_det_f));
    let what = "smallest det F over all tets, elastic extensions";
    page.check(what, least, "", Bound::AtLeast(0.0));
}
