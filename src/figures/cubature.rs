//! How many cubature points are enough, and where they should stand.

use super::press::{Pressed, limb_recipe, press, press_full_space};
use super::{Bound, Curves, Figure, Page, Studio};
use crate::Result;
use crate::bake::{
    CubatureMethod, CubatureRecipe, HandlePlace, HandleRegion, Recipe, Sampling, Truncation, bake,
};
use crate::material::{Material, Orthotropic};
use crate::reference::min_det_f;
use crate::sample::Limb;
use std::sync::Arc;

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

/// The same press in one basis, with ever more points, placed in three ways, in two or three tissues.
fn draw(studio: &Studio) -> Result<Page> {
    let mut page = Page::new(
        "The bone press on mesh S, 8 mm deep, with the same handles throughout: what differs is which tets the tissue's \
         energy is summed over. Error is that of the skin's displacement against the sum over all tets, relative, L2. \
         Points by stiffness stand where the handles make the tissue stiff; uniform and random points know nothing of \
         the handles. What that adds to the error that all tets in the same basis have against the full space is the other \
         measure: at ten points a handle it is to be a fifth at most. A saturating tissue stiffens steeply, and a single point that is strained more than what it \
         stands for stiffens for all of it: the clamp bounds that. (The \
         saturating tissue here saturates at half the strain of the default one, so that the press reaches the clamp.)",
    );
    let saturating = |limit| {
        Material::Orthotropic(Orthotropic {
            saturation_rates: Orthotropic::default().saturation_rates.map(|a| 4.0 * a),
            saturation_limit: limit,
            ..Orthotropic::default()
        })
    };
    let tissues = [
        ("stable neo-Hookean", None),
        ("saturating, clamped at Q = 3", Some(saturating(3.0))),
        ("saturating, not clamped", Some(saturating(30.0))),
    ];
    let tissues = studio.pick(&tissues[..2], &tissues[..]);
    let numbers: &[f64] = studio.pick(&[3.0, 10.0], &[2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 20.0]);
    for (tissue, material) in tissues {
        let handles = studio.pick(30, 60);
        let whole = recipe(handles, *material, None);
        let full = press_full_space(&bake(&Limb::S.body()?, &whole, &mut |_| {})?.0, &DEPTHS)?;
        let (whole, whole_det) = pressed(&whole)?;
        let basis_error = whole.relative_error(&full);
        let mut curves =
            Curves::new(tissue, "points a handle", "error against all tets (%)").logarithmic();
        let mut rows = Vec::new();
        for (name, sampling) in SAMPLINGS {
            let mut errors = Vec::new();
            for &number in numbers {
                // Too few points may leave a handle without stiffness: such a system cannot be solved.
                let found = pressed(&recipe(handles, *material, Some((sampling, number)))).ok();
                let error = found.as_ref().map(|f| 100.0 * f.0.relative_error(&whole));
                let added = found
                    .as_ref()
                    .map(|f| f.0.relative_error(&full) / basis_error - 1.0);
                if let (None, Sampling::Stiffness, 10.0, Some(added)) =
                    (material, sampling, number, added)
                {
                    let what =
                        format!("{tissue}: what 10 points a handle add to the error of all tets");
                    page.check(what, 100.0 * added, "%", Bound::AtMost(20.0));
                }
                errors.extend(error.map(|e| (number, e)));
                let told = |value: Option<String>| value.unwrap_or_else(|| "–".into());
                rows.push(vec![
                    name.into(),
                    number.to_string(),
                    told(error.map(|e| format!("{e:.2} %"))),
                    told(added.map(|a| format!("{:+.1} %", 100.0 * a))),
                    told(found.as_ref().map(|f| format!("{:.2}", f.0.force()))),
                    told(found.as_ref().map(|f| format!("{:.3}", f.1))),
                ]);
            }
            if sampling == Sampling::Stiffness
                && material.is_none()
                && let (Some(first), Some(last)) = (errors.first(), errors.last())
            {
                page.check(
                    format!(
                        "{tissue}: error with {} points a handle over that with {}",
                        last.0, first.0
                    ),
                    last.1 / first.1,
                    "",
                    Bound::AtMost(0.8),
                );
            }
            curves = curves.dots(name, errors);
        }
        page.curves(curves);
        page.table(
            &format!(
                "{tissue}; all tets: {:.2} N, smallest det F {whole_det:.3}, {:.1} % off the full space's {:.2} N",
                whole.force(),
                100.0 * basis_error,
                full.force()
            ),
            &[
                "points",
                "a handle", "against all tets", "added to the error of all tets",
                "force (N)",
                "smallest det F over all tets",
            ],
            rows,
        );
    }
    Ok(page)
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
            place: HandlePlace::Volume,
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
    let smallest = min_det_f(&avatar.layer, &pressed.state);
    Ok((pressed, smallest))
}
