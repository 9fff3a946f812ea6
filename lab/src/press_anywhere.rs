//! Presses where nobody foresaw them, with more and more fine handles awake.

mod presses;
mod trials;
mod truth;

use super::awake::Points;
use super::press::relative_error;
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use presses::{Press, presses};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use supple::Result;
use supple::model::Avatar;
use supple_bake::{FineExtension, FineRecipe, HandleRegion, Recipe};
use supple_pictures::Curves;
use supple_samples::Sample;
use supple_scene::{AvatarSource, BodyOrigin, BodySource, parse_avatar_source};
use trials::{Form, Forms, Trial, trial};
use truth::{Truth, truth};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "press_anywhere",
    title: "Pressed anywhere, with handles that wake",
    paper: "",
    draw,
};

/// Bodies with a name; others are files.
const SAMPLES: [&str; 4] = ["limb_s", "limb_m", "hand", "body"];
/// Fine handles awake.
const BUDGETS: [usize; 4] = [0, 15, 30, 60];
/// Layers with fewer are pressed with every tet integrated each time, others once.
const FEW_TETS: usize = 10_000;
/// How many the default has.
const BUDGET: usize = 30;

/// A press and what every space made of it.
#[derive(Serialize)]
struct Outcome {
    body: String,
    press: Press,
    /// The full space's, N.
    force: f64,
    /// The full space's.
    min_det_f: f64,
    trials: Vec<Trial>,
    #[serde(skip)]
    truth: Truth,
}

fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "A sphere is pushed into the skin at places that a seed draws: anywhere on what is soft, within 30° of the \
         normal, a radius of 10 to 40 mm, as deep as a fifth to half of the layer. The bake is the automatic one; it \
         knows nothing of the places. Beside its coarse handles it has fine ones that sleep, and here the nearest 15, 30 \
         or 60 of them are awake. Truth is the full space in equilibrium, in ten load steps.",
    );
    let bodies = match &runner.presses.bodies[..] {
        [] => runner
            .pick(&["limb_s"][..], &["limb_s", "limb_m"])
            .iter()
            .map(|b| b.to_string())
            .collect(),
        asked => asked.to_vec(),
    };
    let count = runner.presses.count.unwrap_or(runner.pick(3, 5));
    let mut outcomes = Vec::new();
    for name in &bodies {
        let forms = forms(runner, name)?;
        let fine = &forms.elastic.fine;
        page.text(format!(
            "{name}: {} coarse handles, {} fine ones {:.1} mm apart; {} coarse cubature points, {} more that sleep; {:.1} MB.",
            forms.elastic.handles.len(),
            fine.len(),
            1e3 * fine.spacing,
            forms.elastic.cubature.len(),
            fine.points.len(),
            1e-6 * fine.bytes() as f64,
        ));
        let drawn = presses(&forms.elastic, runner.presses.seed, count);
        for (k, press) in drawn.into_iter().enumerate() {
            // All tets of a large layer are dear.
            let few = forms.elastic.layer.mesh.tets.len() < FEW_TETS;
            let all_tets = k == 0 || few && !runner.small();
            outcomes.push(outcome(runner, name, &forms, press, all_tets)?);
            runner.progress(&format!("presses on {name}"), k + 1, count);
        }
    }
    report(runner, &outcomes, &mut page);
    if !runner.small() {
        anchor(runner, &mut page)?;
    }
    page.data("presses", &outcomes)?;
    Ok(page)
}

/// The automatic bake of a sample or a character's file, but for the limbs' tissue, which is the benchmark's. Elastic coarse
/// columns are made of the small limb alone: in dense bases every point is dear.
fn forms(runner: &Runner, body: &str) -> Result<Forms> {
    let is_sample = SAMPLES.contains(&body);
    let limb = is_sample && body.starts_with("limb");
    let avatar = |extension: &str| {
        let key = if is_sample { "sample" } else { "model" };
        let mut text =
            format!("{key} = {body:?}\n[bake.fine_handles]\nextension = {extension:?}\n");
        if limb {
            text +=
                "[bake.material.stable_neo_hookean]\nyoungs_modulus = 30e3\npoissons_ratio = 0.4\n";
        }
        runner.avatar(&parse_avatar_source(
            &text,
            Path::new("press_anywhere.toml"),
        )?)
    };
    let all = body == SAMPLES[0] && !runner.small();
    Forms::new(avatar("elastic")?, avatar("biharmonic")?, all)
}

fn source(sample: Sample, recipe: Recipe) -> AvatarSource {
    BodySource {
        from: BodyOrigin::Sample {
            sample,
            betas: Vec::new(),
        },
        scale: None,
        up: None,
        bake: Some(recipe),
    }
    .into()
}

fn outcome(
    runner: &Runner,
    body: &str,
    forms: &Forms,
    press: Press,
    all_tets: bool,
) -> Result<Outcome> {
    let truth = truth(&forms.elastic, &press, runner.cache())?;
    let mut trials = Vec::new();
    for form in forms.list() {
        let small = if form == Form::Mixed {
            &[0, BUDGET][..]
        } else {
            &[BUDGET]
        };
        for &budget in runner.pick(small, &BUDGETS) {
            trials.push(trial(
                forms,
                &press,
                &truth,
                form,
                budget,
                Points::TwoLevels,
            )?);
        }
    }
    if all_tets {
        let whole = Points::AllTets;
        trials.push(trial(forms, &press, &truth, Form::Mixed, BUDGET, whole)?);
    }
    Ok(Outcome {
        body: body.into(),
        press,
        force: truth.pressed.force(),
        min_det_f: truth.min_det_f,
        trials,
        truth,
    })
}

impl Outcome {
    fn trial(&self, form: Form, budget: usize, all_tets: bool) -> Option<&Trial> {
        let mut trials = self.trials.iter();
        // A body may have fewer handles than the budget.
        trials.rfind(|t| t.form == form && t.awake <= budget && t.all_tets == all_tets)
    }

    /// Distance of the mixed answer from that of all tets, relative to the truth's displacement.
    fn cubature_share(&self) -> Option<f64> {
        let [own, whole] = [false, true].map(|all| self.trial(Form::Mixed, BUDGET, all));
        let (own, whole) = (&own?.displacement, &whole?.displacement);
        let size = norm(&self.truth.pressed.displacement);
        Some(relative_error(own, whole) * norm(whole) / size)
    }
}

fn norm(v: &[DVec3]) -> f64 {
    v.iter().map(|u| u.length_squared()).sum::<f64>().sqrt()
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

fn report(runner: &Runner, outcomes: &[Outcome], page: &mut Page) {
    let rows = outcomes.iter().map(|o| {
        let (p, own) = (&o.press, o.trial(Form::Mixed, BUDGET, false));
        let error = |budget: usize| {
            let trial = o.trial(Form::Mixed, budget, false);
            trial.map_or(String::new(), |t| format!("{:.1}", 100.0 * t.error))
        };
        let [x, y, z] = (1e3 * p.place).to_array();
        vec![
            o.body.clone(),
            format!("{x:.0} {y:.0} {z:.0}"),
            format!("{:.0}", 1e3 * p.radius),
            format!("{:.1} of {:.1}", 1e3 * p.depth, 1e3 * p.layer),
            error(0),
            error(BUDGET),
            o.cubature_share()
                .map_or(String::new(), |s| format!("{:.1}", 100.0 * s)),
            format!("{:.2}", o.force),
            own.map_or(String::new(), |t| format!("{:.2}", t.force)),
            format!("{:.2}", o.min_det_f),
            own.map_or(String::new(), |t| format!("{:.2}", t.min_det_f)),
        ]
    });
    page.table(
        "Each press: error of the skin's displacement (relative L2) with none and 30 of the fine handles awake, coarse \
         handles biharmonic and fine ones elastic; how far the cubature takes the latter from the answer of all tets.",
        &[
            "body",
            "place (mm)",
            "radius (mm)",
            "depth (mm)",
            "error, none awake (%)",
            "error, 30 awake (%)",
            "cubature (%)",
            "force, full space (N)",
            "force, 30 awake (N)",
            "det F, full space",
            "det F, 30 awake",
        ],
        rows.collect(),
    );
    let budgets = runner.pick(&[0, BUDGET][..], &BUDGETS);
    let median_error = |form: Form, budget: usize| {
        let trials = outcomes.iter().filter_map(|o| o.trial(form, budget, false));
        100.0 * median(trials.map(|t| t.error))
    };
    let forms: Vec<Form> = (Form::ALL.into_iter())
        .filter(|form| median_error(*form, BUDGET).is_finite())
        .collect();
    let mut curves = Curves::new("", "fine handles awake", "median error (%)");
    let mut rows = Vec::new();
    for &form in &forms {
        let points = budgets.iter().map(|&b| (b as f64, median_error(form, b)));
        let points = points.filter(|p| p.1.is_finite());
        curves = curves.dots(form.name(), points);
        for &budget in budgets {
            let trials = || outcomes.iter().filter_map(|o| o.trial(form, budget, false));
            let worst = trials().map(|t| t.error).fold(0.0, f64::max);
            let ratio = outcomes.iter().filter_map(|o| {
                let trial = o.trial(form, budget, false)?;
                Some(trial.force / o.force)
            });
            rows.push(vec![
                form.name().to_string(),
                budget.to_string(),
                format!("{:.1}", median_error(form, budget)),
                format!("{:.1}", 100.0 * worst),
                format!("{:.2}", median(ratio)),
                format!(
                    "{:.2}",
                    trials().map(|t| t.min_det_f).fold(f64::INFINITY, f64::min)
                ),
                format!("{:.0}", median(trials().map(|t| t.ms))),
            ]);
        }
    }
    page.curves(curves);
    page.table(
        "All presses. The time is that of all ten load steps, iterated until they converge, with every column a block.",
        &[
            "form",
            "awake",
            "median error (%)",
            "worst error (%)",
            "force by the full space's",
            "least det F",
            "time (ms)",
        ],
        rows,
    );
    page.check(
        "median error with 30 awake, mixed",
        median_error(Form::Mixed, BUDGET),
        "%",
        Bound::AtMost(runner.pick(30.0, 32.0)),
    );
    page.check(
        "the same by that with none awake",
        median_error(Form::Mixed, BUDGET) / median_error(Form::Mixed, 0),
        "",
        Bound::AtMost(0.25),
    );
    page.check(
        "largest distance to the answer of all tets",
        100.0 * (outcomes.iter().filter_map(Outcome::cubature_share)).fold(0.0, f64::max),
        "%",
        Bound::AtMost(runner.pick(8.0, 16.0)),
    );
    let least = outcomes
        .iter()
        .filter_map(|o| o.trial(Form::Mixed, BUDGET, false))
        .fold(f64::INFINITY, |m, t| m.min(t.min_det_f));
    page.check(
        "smallest det F over all tets, 30 awake, mixed",
        least,
        "",
        Bound::AtLeast(0.0),
    );
}

/// The bone press of the method page: 82 coarse handles over the whole limb, every other skin vertex a fine one, all tets.
fn anchor(runner: &Runner, page: &mut Page) -> Result<()> {
    let source = |extension| {
        let recipe = Recipe {
            handles: vec![HandleRegion {
                count: Some(82),
                ..HandleRegion::default()
            }],
            fine_handles: Some(FineRecipe {
                spacing: Some(1e-3),
                extension,
                ..FineRecipe::default()
            }),
            captured_under_gravity: true,
            ..super::press::limb_recipe()
        };
        source(Sample::LimbS, recipe)
    };
    let elastic: Arc<Avatar> = runner.avatar(&source(FineExtension::Elastic))?;
    let biharmonic = runner.avatar(&source(FineExtension::Biharmonic))?;
    let forms = Forms::new(elastic, biharmonic, true)?;
    let mut rows = Vec::new();
    for (x, depth) in [(0.1, 0.012), (0.163, 0.008)] {
        let press = Press {
            vertex: 0,
            place: DVec3::new(x, 0.0, 0.04),
            normal: DVec3::Z,
            direction: DVec3::NEG_Z,
            radius: 0.03,
            depth,
            layer: 0.025,
        };
        let truth = truth(&forms.elastic, &press, runner.cache())?;
        for (form, points) in [
            (Form::Biharmonic, Points::AllTets),
            (Form::Mixed, Points::AllTets),
            (Form::Mixed, Points::TwoLevels),
            (Form::Elastic, Points::TwoLevels),
        ] {
            let mut row = vec![
                format!("{:.0} mm at x = {x}", 1e3 * depth),
                form.name().to_string(),
                match points {
                    Points::AllTets => "all tets".into(),
                    Points::TwoLevels => "two levels".to_string(),
                },
            ];
            for budget in BUDGETS {
                let t = trial(&forms, &press, &truth, form, budget, points)?;
                row.push(format!("{:.1} ({:.1} N)", 100.0 * t.error, t.force));
            }
            row.push(format!("{:.1} N", truth.pressed.force()));
            rows.push(row);
        }
    }
    page.table(
        "The bone press on mesh S with 82 coarse handles that do not know it: error of the skin's displacement in % and force.",
        &[
            "press",
            "form",
            "points",
            "none awake",
            "15",
            "30",
            "60",
            "full space",
        ],
        rows,
    );
    Ok(())
}
