//! Ripples of a palm over fine cylinders.

use super::spectrum::{Sample, between, peak, spectrum};
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use supple::Result;
use supple::internal::cpu::skin_displacement;
use supple::model::{Avatar, State};
use supple_pictures::Curves;
use supple_scene::Scene;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "cylinders",
    title: "A palm over fine cylinders",
    paper: "figure 8",
    draw,
};

/// The strip of skin that the cylinders touch, in the reference shape.
struct Strip {
    low: DVec3,
    high: DVec3,
    /// Into the tissue.
    inward: DVec3,
}

/// Presses the skin onto cylinders of equal spacing along x and slides it by half of that: the displacement has
/// ripples of that spacing, which stay with the cylinders.
fn draw(runner: &Runner) -> Result<Page> {
    let scene = runner.scene(runner.pick("limb_cylinders", "palm_cylinders"))?;
    let strip = match runner.small() {
        true => Strip {
            low: DVec3::new(0.02, -0.012, 0.02),
            high: DVec3::new(0.23, 0.012, 0.05),
            inward: -DVec3::Z,
        },
        false => Strip {
            low: DVec3::new(0.018, -0.036, -0.05),
            high: DVec3::new(0.098, -0.016, -0.005),
            inward: DVec3::Z,
        },
    };
    let avatar = runner.avatar_of(&scene)?;
    let run = runner.play(&scene, &avatar)?;
    let places: Vec<f64> = (scene.colliders.iter())
        .map(|c| c.motion.at(0.0).position.x)
        .collect();
    let spacing = (places[places.len() - 1] - places[0]) / (places.len() as f64 - 1.0);
    let mut page = Page::new(format!(
        "Skin is laid on {} cylinders, {:.0} mm apart, and slides along them by half of that. Between the cylinders \
         the tissue stays out, over them it is pushed in: the displacement ripples with their spacing, and the \
         ripples stay with the cylinders, not with the skin.",
        places.len(),
        1e3 * spacing
    ));
    page.picture(
        "cylinders",
        runner.strip(&scene, &avatar, &run),
        "pressed, and after the slide",
    );
    let moments = [
        ("pressed", scene.measure.full_press),
        ("after the slide", slid(&scene)),
    ];
    let mut profiles = Curves::new(
        "Displacement into the tissue",
        "along the cylinders' row (mm)",
        "mm",
    );
    let mut waves = Curves::new("Its waves", "wavelength (mm)", "amplitude (mm)");
    let mut profile = Vec::new();
    for (name, time) in moments {
        let state = &run.recording.states[scene.step_at(time)];
        let samples = samples(&avatar, state, &strip);
        let spectrum = spectrum(&samples, between(0.45 / spacing, 2.2 / spacing, 350));
        let (frequency, amplitude) = peak(&spectrum);
        let check = |what: &str| format!("{name}: {what}");
        page.check(
            check("wavelength of the ripples, in spacings"),
            1.0 / (frequency * spacing),
            "",
            Bound::Within(0.85, 1.15),
        );
        page.check(
            check("their amplitude"),
            1e3 * amplitude,
            "mm",
            Bound::AtLeast(0.2),
        );
        let smooth = smoothed(&samples, 0.12 * spacing, &strip);
        profiles = profiles.line(name, smooth.iter().map(|(x, d)| (1e3 * x, 1e3 * d)));
        waves = waves.line(name, spectrum.iter().map(|(f, a)| (1e3 / f, 1e3 * a)));
        profile.push(smooth);
    }
    page.curves(profiles);
    page.curves(waves);
    page.check(
        "correlation of the two profiles on the skin",
        correlation(&profile[0], &profile[1]),
        "",
        Bound::AtMost(0.0),
    );
    page.check_intact("", &run.report);
    Ok(page)
}

/// When the slide has ended: shortly before what moves last begins to, s.
fn slid(scene: &Scene) -> f64 {
    let drivers = scene.targets.iter().map(|t| &t.motion);
    let mut motions = drivers.chain(scene.colliders.iter().map(|c| &c.motion));
    let slide = motions.find_map(|m| m.x.last().filter(|_| m.x.len() > 1));
    slide.map_or(0.0, |key| key[0] + 0.05)
}

/// Displacement into the tissue at the strip's vertices, weighted by their area; m over m.
fn samples(avatar: &Avatar, state: &State, strip: &Strip) -> Vec<Sample> {
    let displacement = skin_displacement(avatar, state);
    let skin = &avatar.skin;
    let inside = |x: DVec3| x.cmpge(strip.low).all() && x.cmple(strip.high).all();
    (0..skin.len())
        .filter(|&v| inside(skin.position[v]))
        .map(|v| Sample {
            at: skin.position[v].x,
            value: displacement[v].dot(strip.inward),
            weight: skin.measure[v],
        })
        .collect()
}

/// The mean around each of 121 places along the strip, by Gaussian weights of the given width, m.
fn smoothed(samples: &[Sample], width: f64, strip: &Strip) -> Vec<(f64, f64)> {
    between(strip.low.x, strip.high.x, 120)
        .map(|x| {
            let (sum, total) = samples.iter().fold((0.0, 0.0), |(sum, total), s| {
                let weight = s.weight * (-0.5 * ((s.at - x) / width).powi(2)).exp();
                (sum + weight * s.value, total + weight)
            });
            (x, sum / total)
        })
        .filter(|(_, mean)| mean.is_finite())
        .collect()
}

/// Pearson's correlation of two profiles over the same places.
fn correlation(a: &[(f64, f64)], b: &[(f64, f64)]) -> f64 {
    let mean = |p: &[(f64, f64)]| p.iter().map(|q| q.1).sum::<f64>() / p.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let sums = a.iter().zip(b).fold([0.0; 3], |s, (p, q)| {
        let (x, y) = (p.1 - mean_a, q.1 - mean_b);
        [s[0] + x * y, s[1] + x * x, s[2] + y * y]
    });
    sums[0] / (sums[1] * sums[2]).sqrt()
}
