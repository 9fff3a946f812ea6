//! How many cubature points are enough, and where they should stand.

use super::press::{Pressed, limb_recipe, press, press_full_space};
use super::{Bound, Figure, Page, Runner};
use std::sync::Arc;
use supple::Result;
use supple::internal::cpu::min_det_f;
use supple::material::{Material, Orthotropic};
use supple_bake::{
    CubatureMethod, CubatureRecipe, HandleCandidates, HandleRegion, Recipe, Sampling, Truncation,
    bake,
};
use supple_pictures::Curves;
use supple_samples::Limb;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "cubature",
    title: "Cubature against all tets",
    paper: "section 4.2",
    draw,
};

/// m.
const DEPTHS: [f64; 4] = [0.002, 0.004, 0.006, 0.008];

/// The ways to place points.
const SAMPLINGS: [(&str, Sampling); 3] = [
    ("by stiffness (importance)", Sampling::Stiffness),
    ("uniform", Sampling::Uniform),
    ("random", Sampling::Random),
];

/// How often points are asked for a handle where what they add is checked: enough, by the paper and the recipe.
const ENOUGH: f64 = 10.0;

/// What so many points so placed come to.
struct Sampled {
    sampling: Sampling,
    /// Points a handle.
    number: f64,
    /// Of the skin's displacement against the sum over all tets, relative, L2.
    error: f64,
    /// What that adds to the error of all tets against the full space, of it.
    added: f64,
    force: f64,
    min_det_f: f64,
}

/// The same press in one basis, with ever more points, placed in three ways, in two or three tissues.
fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "The bone press on mesh S, 8 mm deep, with the same handles throughout: what differs is which tets the tissue's \
         energy is summed over. Error is that of the skin's displacement against the sum over all tets, relative, L2. \
         Points by stiffness stand where the handles make the tissue stiff; uniform and random points know nothing of \
         the handles. What that adds to the error that all tets in the same basis have against the full space is the other \
         measure: at ten points a handle it is to be a fifth at most.",
    );
    page.text(
        "A saturating tissue stiffens steeply, and a single point that is strained more than what it stands for stiffens \
         for all of it: the clamp bounds that. The saturating tissue here saturates at a quarter of the strain of the \
         default one, so that the press reaches the clamp.",
    );
    let saturating = |limit| {
        Material::Orthotropic(Orthotropic {
            // Q goes with the square of the strain.
            saturation_rates: Orthotropic::default().saturation_rates.map(|a| 16.0 * a),
            saturation_limit: limit,
            ..Orthotropic::default()
        })
    };
    let tissues = [
        ("stable neo-Hookean", None),
        ("saturating, clamped at Q = 1", Some(saturating(1.0))),
        ("saturating, not clamped", Some(saturating(30.0))),
    ];
    let numbers: &[f64] = runner.pick(&[3.0, 10.0], &[2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 20.0]);
    let mut forces = Vec::new();
    for (tissue, material) in tissues {
        let handles = runner.pick(30, 60);
        let whole = recipe(handles, material, None);
        let full = press_full_space(&bake(&Limb::S.body()?, &whole, &mut |_| {})?.0, &DEPTHS)?;
        let (whole, whole_det) = pressed(&whole)?;
        let basis_error = whole.relative_error(&full);
        forces.push(whole.force());
        let mut found = Vec::new();
        for (_, sampling) in SAMPLINGS {
            for &number in numbers {
                // Too few points may leave a handle without stiffness: such a system cannot be solved.
                let recipe = recipe(handles, material, Some((sampling, number)));
                let Ok((sampled, min_det_f)) = pressed(&recipe) else {
                    continue;
                };
                found.push(Sampled {
                    sampling,
                    number,
                    error: sampled.relative_error(&whole),
                    added: sampled.relative_error(&full) / basis_error - 1.0,
                    force: sampled.force(),
                    min_det_f,
                });
            }
        }
        show(tissue, &found, &mut page);
        page.text(format!(
            "{tissue}, all tets: {:.2} N, smallest det F {whole_det:.3}, {:.1} % off the full space's {:.2} N.",
            whole.force(),
            100.0 * basis_error,
            full.force()
        ));
        check(tissue, &found, &mut page);
    }
    page.check(
        "force of the saturating tissue without the clamp, by that with it",
        forces[2] / forces[1],
        "",
        Bound::AtLeast(1.02),
    );
    Ok(page)
}

fn show(tissue: &str, found: &[Sampled], page: &mut Page) {
    let mut curves =
        Curves::new(tissue, "points a handle", "error against all tets (%)").logarithmic();
    let mut rows = Vec::new();
    for (name, sampling) in SAMPLINGS {
        let of = || found.iter().filter(move |f| f.sampling == sampling);
        curves = curves.dots(name, of().map(|f| (f.number, 100.0 * f.error)));
        rows.extend(of().map(|f| {
            vec![
                name.into(),
                f.number.to_string(),
                format!("{:.2} %", 100.0 * f.error),
                format!("{:+.1} %", 100.0 * f.added),
                format!("{:.2}", f.force),
                format!("{:.3}", f.min_det_f),
            ]
        }));
    }
    page.curves(curves);
    page.table(
        tissue,
        &[
            "placed",
            "points a handle",
            "against all tets",
            "added to their error",
            "force (N)",
            "smallest det F over all tets",
        ],
        rows,
    );
}

/// Points are a rule of quadrature. Monte Carlo's converges as N^−½; a rule that is fitted to volume, first moment and each
/// handle's stiffness must be at least as fast, and beat points that are strewn. That ten points a handle add a fifth at most to
/// what all tets in the same basis are off is what the method asks for (its §8).
fn check(tissue: &str, found: &[Sampled], page: &mut Page) {
    let of = |sampling| {
        let found = found.iter().filter(move |f| f.sampling == sampling);
        found.collect::<Vec<_>>()
    };
    let (fitted, random) = (of(Sampling::Stiffness), of(Sampling::Random));
    if let Some(enough) = fitted.iter().find(|f| f.number == ENOUGH) {
        let what = format!("{tissue}: what {ENOUGH} points a handle add to the error of all tets");
        page.check(what, 100.0 * enough.added, "%", Bound::AtMost(20.0));
    }
    if let (Some(first), Some(last)) = (fitted.first(), fitted.last()) {
        page.check(
            format!(
                "{tissue}: error with {} points a handle over that with {}",
                last.number, first.number
            ),
            last.error / first.error,
            "",
            Bound::AtMost((first.number / last.number).sqrt()),
        );
    }
    let pairs = fitted.iter().flat_map(|f| {
        let other = random.iter().find(|r| r.number == f.number);
        other.map(|r| (f.error / r.error).ln())
    });
    let logs: Vec<f64> = pairs.collect();
    page.check(
        format!("{tissue}: error of points by stiffness over that of random ones, geometric mean"),
        (logs.iter().sum::<f64>() / logs.len() as f64).exp(),
        "",
        Bound::AtMost(1.0),
    );
}

/// A bake with so many handles around the contact; every tet a point where no points are asked for.
fn recipe(handles: usize, material: Option<Material>, points: Option<(Sampling, f64)>) -> Recipe {
    let tissue = limb_recipe();
    let mut cubature = CubatureRecipe {
        all_tets: points.is_none(),
        ..CubatureRecipe::default()
    };
    if let Some((sampling, number)) = points {
        cubature.points_per_handle = number;
        cubature.method = CubatureMethod {
            sampling,
            ..CubatureMethod::default()
        };
    }
    Recipe {
        material: material.or(tissue.material),
        handles: vec![HandleRegion {
            candidates: HandleCandidates::Volume,
            within: Some([[0.04, -0.045, -0.005], [0.16, 0.045, 0.045]]),
            count: Some(handles),
            ..HandleRegion::default()
        }],
        truncation: Truncation::default(),
        cubature,
        ..tissue
    }
}

/// The press, and the smallest det F over all tets.
fn pressed(recipe: &Recipe) -> Result<(Pressed, f64)> {
    let avatar = Arc::new(bake(&Limb::S.body()?, recipe, &mut |_| {})?.0);
    let pressed = press(&avatar, &DEPTHS)?;
    let smallest = min_det_f(&avatar, &pressed.state);
    Ok((pressed, smallest))
}
