//! Tissue pressed to 40 % of its thickness, of several materials; and what they answer to being pulled.

use super::measure::volume_ratios;
use super::{Bound, Figure, Page, Runner, uniaxial};
use glam::{DMat3, DVec3};
use std::sync::Arc;
use supple::Result;
use supple::material::{Material, Orthotropic};
use supple::model::{Avatar, State, Surface};
use supple_bake::{HandleRegion, Recipe, bake};
use supple_pictures::{Camera, ColourScale, Curves, Image, Legend, Mesh, Panel, from_srgb};
use supple_samples::Limb;
use supple_scene::{Scene, SceneRun};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "compression",
    title: "Compression by 60 %, saturation and its clamp",
    paper: "section 4.2",
    draw,
};

/// How far the plate presses, of the tissue's thickness.
const COMPRESSION: f64 = 0.6;

fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "A plate presses the tissue around a bone to 40 % of its thickness at 60 steps a second with one Newton \
         iteration a step, every node solved for: stable neo-Hookean tissue, orthotropic tissue, and one that saturates \
         early, clamped soon and late; all with ν = 0.45. Between plate and bone the tissue loses more volume than a bar \
         whose sides are free, and less than one whose sides are held.",
    );
    press(runner, &mut page)?;
    pull(&mut page);
    clamp(&mut page);
    Ok(page)
}

/// What is pressed: the ground substance, the tissue, and one that saturates four times as soon, at two clamps.
fn materials() -> Vec<(String, Material)> {
    let tissue = Orthotropic::default();
    let early = |saturation_limit: f64| {
        let model = Orthotropic {
            saturation_rates: tissue.saturation_rates.map(|a| 4.0 * a),
            saturation_limit,
            ..tissue
        };
        let name = format!("saturating early, Q up to {saturation_limit}");
        (name, Material::Orthotropic(model))
    };
    vec![
        (
            "stable neo-Hookean".into(),
            Material::StableNeoHookean(tissue.ground()),
        ),
        (
            "orthotropic, Q up to 3".into(),
            Material::Orthotropic(tissue),
        ),
        early(0.5),
        early(12.0),
    ]
}

fn press(runner: &Runner, page: &mut Page) -> Result<()> {
    let scene = runner.scene("compression")?;
    let limb = runner.pick(
        Limb {
            length: 0.08,
            stations: 8,
            ..Limb::S
        },
        Limb::S,
    );
    // Every node is solved for: where handles stand does not matter.
    let recipe = Recipe {
        captured_under_gravity: false,
        handles: vec![HandleRegion {
            count: Some(12),
            ..HandleRegion::default()
        }],
        ..Recipe::default()
    };
    let avatar = bake(&limb.body()?, &recipe, &mut |_| {})?.0;
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    for (name, material) in materials() {
        let avatar = Arc::new(Avatar {
            material,
            ..avatar.clone()
        });
        let (avatar, run) = runner.play_full_space(&scene, &avatar)?;
        let pressed = state_at(&scene, &run, scene.measure.full_press);
        panels.push(Panel {
            image: picture(runner, &scene, &run, &avatar, pressed),
            caption: name.clone(),
        });
        let report = &run.report;
        let thinner = compression(&limb, &run);
        let [held, volume, free] =
            volume_change(&limb, &avatar, pressed, thinner).map(|v| 100.0 * v);
        let motion = last_motion(&scene, &run);
        rows.push(vec![
            name.clone(),
            format!("{:.1} %", 100.0 * thinner),
            format!("{:.3}", report.det_f()),
            format!("{volume:.1} %"),
            format!("{held:.1} to {free:.1} %"),
            format!("{:.0} N", 0.1 * report.contact_force_n / limb.length),
            format!("{motion:.1e} mm"),
        ]);
        for (what, value, unit, bound) in [
            (
                "compression",
                thinner,
                "",
                Bound::Within(COMPRESSION - 0.01, COMPRESSION + 0.03),
            ),
            (
                "smallest det F of all tets and steps",
                report.det_f(),
                "",
                Bound::AtLeast(0.1),
            ),
            (
                "motion in the last step under the plate",
                motion,
                "mm",
                Bound::AtMost(0.01),
            ),
            (
                "volume change between plate and bone",
                volume,
                "%",
                Bound::Within(held, free),
            ),
            (
                "skin from its rest half a second after the release",
                report.residual_displacement_mm,
                "mm",
                Bound::AtMost(0.5),
            ),
        ] {
            page.check(format!("{name}: {what}"), value, unit, bound);
        }
    }
    let legend = Legend {
        title: "volume, of that at rest".into(),
        scale: volume_scale(),
    };
    page.picture(
        "pressed",
        runner.sheet(panels, 2, Some(legend)),
        "The layer under the plate, seen along the bone; coloured by det F.",
    );
    page.table(
        "Under the plate, and over the run",
        &[
            "tissue",
            "compression",
            "least det F",
            "volume change between plate and bone",
            "with sides held to free",
            "force per 10 cm",
            "motion in the last step",
        ],
        rows,
    );
    Ok(())
}

fn volume_scale() -> ColourScale {
    ColourScale::about(1.0, 0.5)
}

/// The layer's mesh under the plate, seen along the bone.
fn picture(
    runner: &Runner,
    scene: &Scene,
    run: &SceneRun,
    avatar: &Avatar,
    state: &State,
) -> Image {
    let layer = &avatar.layer;
    // In full space a free node's handle moves it alone, and the one bone is pinned at rest.
    let moved = layer.mesh.nodes.iter().zip(layer.basis.iter());
    let place = |(x, row): (&DVec3, &[(u32, f64)])| {
        let ways = row.iter().map(|&(h, u)| u * state.handles[h as usize]);
        *x + ways.sum::<DVec3>()
    };
    let volumes = volume_ratios(avatar, state);
    let mut sums = vec![(0.0, 0.0); layer.mesh.nodes.len()];
    for (tet, volume) in layer.mesh.tets.iter().zip(volumes) {
        for &n in tet {
            let (sum, count) = &mut sums[n as usize];
            *sum += volume;
            *count += 1.0;
        }
    }
    let scale = volume_scale();
    let tissue = Mesh::coloured(
        Surface {
            positions: moved.map(place).collect(),
            triangles: layer.mesh.boundary_triangles(),
        },
        sums.iter()
            .map(|(sum, count)| scale.colour(sum / count))
            .collect(),
    );
    let plate = &run.snapshots[1].colliders[0];
    let plate = Mesh::collider(&scene.colliders[0].shape, plate, 0.1, from_srgb(0x8fa3b8));
    let radius = 0.05;
    let near = DVec3::new(0.0, 0.0, -0.008);
    let camera = Camera::near(near, radius, DVec3::new(1.0, 0.0, 0.0), DVec3::Z, 1.4);
    runner.picture(&[tissue, plate], camera, [980, 700])
}

/// The recorded state at `time`.
fn state_at<'a>(scene: &Scene, run: &'a SceneRun, time: f64) -> &'a State {
    let states = &run.recording.states;
    &states[scene.step_at(time).min(states.len() - 1)]
}

/// ΣV det F / ΣV − 1 over the tissue above the middle half of the bone, between what it would be if the tissue could not
/// give way sideways and if nothing kept it from that.
///
/// A column of tissue at y, pressed from its height at rest to what is left under the plate, has the stretch s across the
/// skin. Held at its sides it has J = s; a bar with free sides has the J of [`uniaxial::stretches`]. Tissue that sticks to
/// the bone and has neighbours lies between. Within a column s varies, and its mean alone is known: J = s is linear, and
/// of the free bar J is concave in s, so that both bounds hold for the mean.
fn volume_change(limb: &Limb, avatar: &Avatar, state: &State, compression: f64) -> [f64; 3] {
    let points = &avatar.cubature;
    let column = |radius: f64, y: f64| (radius * radius - y * y).sqrt();
    let plate = limb.outer_radius - compression * (limb.outer_radius - limb.inner_radius);
    let (mut sums, mut all) = ([0.0; 3], 0.0);
    for (i, volume) in volume_ratios(avatar, state).into_iter().enumerate() {
        let (place, measure) = (points.position[i], points.measure[i]);
        if place.z < 0.0 || place.y.abs() > 0.5 * limb.inner_radius {
            continue;
        }
        let [skin, bone] = [limb.outer_radius, limb.inner_radius].map(|r| column(r, place.y));
        let stretch = (plate.min(skin) - bone) / (skin - bone);
        let free = uniaxial::stretches(&avatar.material, 0, stretch).element_product();
        for (sum, j) in sums.iter_mut().zip([stretch, volume, free]) {
            *sum += measure * j;
        }
        all += measure;
    }
    sums.map(|sum| sum / all - 1.0)
}

/// How much thinner the layer is under the plate's middle than at rest, of its thickness.
fn compression(limb: &Limb, run: &SceneRun) -> f64 {
    let (rest, pressed) = (&run.snapshots[0].skin, &run.snapshots[1].skin);
    let middle = DVec3::new(0.5 * limb.length, 0.0, limb.outer_radius);
    let nearest = (0..rest.len()).min_by(|&a, &b| {
        rest[a]
            .distance_squared(middle)
            .total_cmp(&rest[b].distance_squared(middle))
    });
    let v = nearest.unwrap_or(0);
    (rest[v].z - pressed[v].z) / (limb.outer_radius - limb.inner_radius)
}

/// How far a node still moves in the last step before the plate leaves, mm.
fn last_motion(scene: &Scene, run: &SceneRun) -> f64 {
    let now = state_at(scene, run, scene.measure.full_press);
    let before = state_at(
        scene,
        run,
        scene.measure.full_press - scene.settings.time_step,
    );
    let moved = now.handles.iter().zip(&before.handles);
    let most = moved.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    1e3 * most
}

const AXES: [&str; 3] = ["across the skin", "along the bone", "around it"];

/// Uniaxial stress against stretch: along each axis, and one family of fibres against its closed form.
fn pull(page: &mut Page) {
    let stretches = || (0..=28).map(|k| 0.4 + 0.05 * f64::from(k));
    let tissue = Material::Orthotropic(Orthotropic::default());
    let mut curves = Curves::new(
        "A bar of tissue, its sides free",
        "stretch",
        "nominal stress, kPa",
    );
    for (axis, name) in AXES.iter().enumerate() {
        let points = stretches().map(|s| (s, 1e-3 * uniaxial::stress(&tissue, axis, s)));
        curves = curves.line(name, points.filter(|p| p.0 <= 1.5));
    }
    page.curves(curves);
    let at = |axis: usize| uniaxial::stress(&tissue, axis, 1.2);
    let [across, along, around] = [0, 1, 2].map(at);
    page.check(
        "stress along the bone over across the skin, at a stretch of 1.2",
        along / across,
        "",
        Bound::AtLeast(1.3),
    );
    page.check(
        "stress along the bone over around it, at a stretch of 1.2",
        along / around,
        "",
        Bound::AtLeast(1.1),
    );

    let one_family = Orthotropic {
        poissons_ratio: 0.4999,
        fibre_moduli: [0.0, 8e3, 0.0],
        saturation_rates: [0.0, 6.0, 0.0],
        ..Orthotropic::default()
    };
    let material = Material::Orthotropic(one_family);
    let measured: Vec<(f64, f64)> = stretches()
        .map(|s| (s, uniaxial::stress(&material, 1, s)))
        .collect();
    let closed = |s: f64| uniaxial::incompressible_stress(&one_family, 1, s);
    let largest = measured.iter().fold(0.0_f64, |a, p| a.max(p.1.abs()));
    let apart = |p: &(f64, f64)| (p.1 - closed(p.0)).abs() / largest;
    let error = measured.iter().map(apart).fold(0.0, f64::max);
    page.curves(
        Curves::new(
            "One family of fibres, ν = 0.4999",
            "stretch",
            "nominal stress, kPa",
        )
        .line(
            "incompressible, closed form",
            stretches().map(|s| (s, 1e-3 * closed(s))),
        )
        .dots("the material", measured.iter().map(|(s, p)| (*s, 1e-3 * p))),
    );
    page.check(
        "one family of fibres against the closed form of incompressible tissue",
        100.0 * error,
        "%",
        Bound::AtMost(0.5),
    );

    // With free sides μ (1 − s) + (λ + μ)(J − 1) s = 0 of the ground substance: J = 1 − μ (1 − s)/((λ + μ) s).
    let ground = Orthotropic::default().ground();
    let ((mu, lambda), s) = (ground.lame(), 1.0 - COMPRESSION);
    let volume = |material: &Material| uniaxial::stretches(material, 0, s).element_product();
    let plain = volume(&Material::StableNeoHookean(ground));
    let closed = 1.0 - mu * (1.0 - s) / ((lambda + mu) * s);
    page.check(
        "volume of a neo-Hookean bar pressed to 40 %, its sides free, ν = 0.45",
        plain,
        "",
        Bound::Within(closed - 1e-9, closed + 1e-9),
    );
    page.check(
        // Its fibres hold its sides, but never beyond where they were.
        "the same of the orthotropic tissue",
        volume(&tissue),
        "",
        Bound::Within(s, closed),
    );
}

/// The energy over the stretch at several clamps: past the limit it grows as a polynomial.
fn clamp(page: &mut Page) {
    let energy = |limit: f64, s: f64| {
        let model = Material::Orthotropic(Orthotropic {
            saturation_limit: limit,
            ..Orthotropic::default()
        });
        model.energy_density(DMat3::from_diagonal(DVec3::new(1.0, s, 1.0)))
    };
    let mut curves = Curves::new(
        "Energy of stretching along the bone",
        "stretch",
        "energy, Pa",
    )
    .logarithmic();
    for limit in [0.0, 1.0, 3.0, 12.0] {
        let points = (1..=60).map(|k| 1.0 + 0.02 * f64::from(k));
        curves = curves.line(
            &format!("Q ≤ {limit}"),
            points.map(|s| (s, energy(limit, s))),
        );
    }
    page.curves(curves);
    // Of degree 6 at most: the ground's volume term; the fibres' is of degree 4.
    for limit in [0.0, 1.0, 3.0] {
        page.check(
            format!("growth of the energy from a stretch of 3 to 6, Q ≤ {limit}"),
            energy(limit, 6.0) / energy(limit, 3.0),
            "",
            Bound::AtMost(64.0),
        );
    }
}
