//! How far tissue sways on its bones, by what is done to the basis, and what that costs a press.

use super::press::{Pressed, limb_recipe, press, press_full_space};
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use std::sync::Arc;
use supple::Result;
use supple::model::Avatar;
use supple_bake::{HandleRegion, Recipe, RestSystem, Truncation, all_tets, bake, full_compliance};
use supple_samples::{Limb, Sample};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "sway",
    title: "Sway: what the basis keeps of it",
    paper: "",
    draw,
};

/// m.
const DEPTHS: [f64; 4] = [0.003, 0.006, 0.009, 0.012];

/// What is done to the basis.
const CUT: Truncation = Truncation {
    keep_sway: Some(false),
    ..KEPT
};
const KEPT: Truncation = Truncation {
    enabled: true,
    below: 0.03,
    above: 0.1,
    keep_sway: Some(true),
};

fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "Bones that are shaken load their tissue with its own mass. Compliance is the work of that load, fᵀ K⁻¹ f \
         with f = M 1 and K at rest, along x, y and z together, as a share of the full space's; by the cubature points \
         and, the basis alone, by all tets. A stiff basis sways less, and faster. Handles stand evenly on the skin; the \
         press is the bone press in equilibrium at 12 mm.",
    );
    let mut rows = Vec::new();
    let limb = Limb::S.body()?;
    let mut truth: Option<Pressed> = None;
    for &count in runner.pick(&[82][..], &[56, 82, 160][..]) {
        let mut of_cut = f64::NAN;
        for (name, truncation) in [
            ("truncated", CUT),
            ("truncated, sway kept", KEPT),
            ("whole", Truncation::OFF),
        ] {
            let recipe = Recipe {
                handles: vec![HandleRegion {
                    count: Some(count),
                    ..HandleRegion::default()
                }],
                truncation,
                ..limb_recipe()
            };
            let avatar = Arc::new(bake(&limb, &recipe, &mut |_| {})?.0);
            let truth = match &truth {
                Some(pressed) => pressed,
                None => truth.insert(press_full_space(&avatar, &DEPTHS)?),
            };
            let pressed = press(&avatar, &DEPTHS)?;
            let error = 100.0 * pressed.relative_error(truth);
            let share = Share::of(&avatar)?;
            let what = format!("limb, {count} handles");
            match name {
                "truncated" => of_cut = error,
                "truncated, sway kept" => {
                    let least = Bound::AtLeast(80.0);
                    page.check(format!("{what}: compliance"), share.points, "%", least);
                    // What 40 to 80 % of twice the displacement are off by is noise of the cubature.
                    if count == 82 {
                        let more = format!("{what}: error of the press over that without");
                        page.check(more, error - of_cut, "points", Bound::AtMost(2.0));
                    }
                }
                _ => {}
            }
            rows.push(share.row(
                &what,
                name,
                &avatar,
                format!("{error:.0} %, {:.1} N", pressed.force()),
            ));
        }
    }
    if !runner.small() {
        let body = Sample::Body.body()?.0;
        for count in [40, 80, 160] {
            for (name, truncation) in [("truncated", CUT), ("truncated, sway kept", KEPT)] {
                let recipe = Recipe {
                    handles: vec![HandleRegion {
                        count: Some(count),
                        soft: 0.6,
                        ..HandleRegion::default()
                    }],
                    truncation,
                    ..Recipe::default()
                };
                let avatar = bake(&body, &recipe, &mut |_| {})?.0;
                let share = Share::of(&avatar)?;
                let what = format!("body, {count} handles");
                if name != "truncated" {
                    let near = Bound::Within(85.0, 115.0);
                    page.check(format!("{what}: compliance"), share.points, "%", near);
                }
                rows.push(share.row(&what, name, &avatar, "–".into()));
            }
        }
    }
    page.table(
        "Compliance under an acceleration of the bones, and what it costs",
        &[
            "what",
            "basis",
            "by points",
            "by all tets",
            "handles a point",
            "press error, force",
        ],
        rows,
    );
    Ok(page)
}

/// Compliance of the reduced tissue in % of the full space's.
struct Share {
    points: f64,
    tets: f64,
}

impl Share {
    fn of(avatar: &Avatar) -> Result<Self> {
        let full: f64 = full_compliance(avatar)?.iter().sum();
        let percent = |avatar: &Avatar| -> Result<f64> {
            let system = RestSystem::of(avatar);
            let along = [DVec3::X, DVec3::Y, DVec3::Z].map(|d| system.compliance(d));
            let sum = along.into_iter().sum::<Result<f64>>()?;
            Ok(100.0 * sum / full)
        };
        Ok(Self {
            points: percent(avatar)?,
            tets: percent(&all_tets(avatar)?)?,
        })
    }

    fn row(&self, what: &str, basis: &str, avatar: &Avatar, press: String) -> Vec<String> {
        let points = &avatar.cubature;
        let entries = points.basis.entries().len() as f64 / points.len() as f64;
        vec![
            what.into(),
            basis.into(),
            format!("{:.0} %", self.points),
            format!("{:.0} %", self.tets),
            format!("{entries:.1}"),
            press,
        ]
    }
}
