//! A finger sliding both ways along a cylinder.

use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use supple::Result;
use supple::collider::Collider;
use supple::internal::cpu::{posed_skin, unposed_skin};
use supple::model::{Avatar, State, Surface};
use supple_pictures::{Camera, ColourScale, Curves, Legend, Mesh, Panel};
use supple_scene::Scene;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "finger_slide",
    title: "A finger slides both ways along a cylinder",
    paper: "figure 10",
    draw,
};

/// How far from the middle of the contact, along the slide, skin counts as ahead of it or behind, m.
const REACH: f64 = 0.015;

/// Draws a finger along a rough cylinder, first towards its tip, then back. I₁ of the skin's right Cauchy–Green
/// tensor tells stretched skin (above 2) from compressed: ahead of the contact, which friction holds back, skin is
/// stretched, behind it compressed, and the two sides swap with the direction.
fn draw(runner: &Runner) -> Result<Page> {
    let scene = runner.scene("finger_slide")?;
    let avatar = runner.avatar_of(&scene)?;
    let run = runner.play(&scene, &avatar)?;
    let states = &run.recording.states;
    let mut page = Page::new(
        "A finger is laid on a rough cylinder and drawn along it, towards its tip and back. Friction holds the skin \
         that touches back: ahead of it skin is stretched, behind it compressed, and the two swap with the \
         direction. The maps show I₁ − 2 of the skin's right Cauchy–Green tensor C on the unposed shape, seen from \
         below: positive where the skin is stretched.",
    );
    page.picture(
        "finger",
        runner.strip(&scene, &avatar, &run),
        "pressed, and sliding forth and back",
    );
    let moments = [("forth", forth(&scene)), ("back", back(&scene))];
    let maps = moments.map(|(_, time)| first_invariant(&avatar, &states[scene.step_at(time)]));
    let spread = quantile(&maps[0], 0.98).max(quantile(&maps[1], 0.98));
    let scale = ColourScale::about(0.0, spread);
    let panels = moments.iter().zip(&maps).map(|((name, time), map)| {
        let skin = unposed_skin(&avatar, &states[scene.step_at(*time)]);
        let mesh = Mesh::coloured(skin, scale.colours(map.iter().copied()));
        let size = [760, 420];
        let aspect = size[0] as f64 / size[1] as f64;
        let from = DVec3::new(0.05, 0.35, 1.0);
        let points = &mesh.surface.positions;
        let camera = Camera::framing(points, from, DVec3::Y, aspect);
        Panel {
            image: runner.picture(&[mesh], camera, size),
            caption: format!("sliding {name}"),
        }
    });
    let legend = Legend {
        title: "I1 - 2 of C".into(),
        scale,
    };
    page.picture(
        "invariant",
        runner.sheet(panels.collect(), 2, Some(legend)),
        "first invariant of the skin's right Cauchy–Green tensor, on the unposed shape, seen from below; the tip is to the left",
    );

    let mut profile = Curves::new(
        "Skin along the slide",
        "from the middle of the contact, towards the tip (mm)",
        "I₁ − 2",
    );
    let mut sides = Vec::new();
    for ((name, time), map) in moments.iter().zip(&maps) {
        let contact = Contact::new(&scene, &avatar, &states[scene.step_at(*time)], *time);
        profile = profile.line(name, contact.profile(&avatar, map));
        let tip = contact.mean(&avatar, map, 1.0);
        let base = contact.mean(&avatar, map, -1.0);
        let (ahead, behind) = match *name {
            "forth" => (tip, base),
            _ => (base, tip),
        };
        page.check(
            format!("sliding {name}: mean of I₁ − 2 behind the contact"),
            behind,
            "",
            Bound::AtMost(-0.01),
        );
        page.check(
            format!("sliding {name}: mean of I₁ − 2 ahead of the contact"),
            ahead,
            "",
            Bound::AtLeast(0.02),
        );
        sides.push((tip, base));
    }
    page.curves(profile);
    let ((tip_forth, base_forth), (tip_back, base_back)) = (sides[0], sides[1]);
    page.check(
        "towards the tip: I₁ sliding forth above I₁ sliding back",
        tip_forth - tip_back,
        "",
        Bound::AtLeast(0.05),
    );
    page.check(
        "towards the base: I₁ sliding back above I₁ sliding forth",
        base_back - base_forth,
        "",
        Bound::AtLeast(0.05),
    );
    page.check_intact("", &run.report);
    Ok(page)
}

/// While it slides towards its tip, s.
fn forth(scene: &Scene) -> f64 {
    scene.output.panels[1].time
}

/// While it slides back, s.
fn back(scene: &Scene) -> f64 {
    scene.output.panels[2].time
}

/// The part of the skin about a contact, in the reference shape.
struct Contact {
    /// Mean place of what touches, weighted by its area.
    middle: DVec3,
}

impl Contact {
    fn new(scene: &Scene, avatar: &Avatar, state: &State, time: f64) -> Self {
        let posed = posed_skin(avatar, state);
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for c in &scene.colliders {
            let place = c.motion.at(time);
            let collider = Collider::new((*c.shape).clone(), place);
            for (v, x) in posed.positions.iter().enumerate() {
                let area = avatar.skin.measure[v];
                if collider.signed_distance(&place, *x).distance < c.margin {
                    sum += area * avatar.skin.position[v];
                    total += area;
                }
            }
        }
        Self {
            middle: sum / total,
        }
    }

    /// (distance along the finger, area) of the skin under the finger and near enough.
    fn near<'a>(&'a self, avatar: &'a Avatar) -> impl Iterator<Item = (usize, f64)> + 'a {
        let normals = Surface {
            positions: avatar.skin.position.clone(),
            triangles: avatar.triangles.clone(),
        }
        .vertex_normals();
        let places = avatar.skin.position.iter().enumerate();
        places
            .filter(move |(v, x)| normals[*v].z < -0.5 && (**x - self.middle).y.abs() < 0.004)
            .map(|(v, x)| (v, x.x - self.middle.x))
            .filter(|(_, along)| along.abs() < REACH)
    }

    /// Mean of `map` over the skin on one side of the middle (the tip's: 1, the base's: −1).
    fn mean(&self, avatar: &Avatar, map: &[f64], side: f64) -> f64 {
        let (mut sum, mut total) = (0.0, 0.0);
        for (v, along) in self.near(avatar) {
            if along * side > 0.0 {
                let area = avatar.skin.measure[v];
                sum += area * map[v];
                total += area;
            }
        }
        sum / total
    }

    /// (distance along the finger, mm; mean of `map`) in slices of 2 mm.
    fn profile(&self, avatar: &Avatar, map: &[f64]) -> Vec<(f64, f64)> {
        const SLICE: f64 = 2e-3;
        let count = (2.0 * REACH / SLICE) as usize;
        let mut slices = vec![(0.0, 0.0); count];
        for (v, along) in self.near(avatar) {
            let slice = &mut slices[(((along + REACH) / SLICE) as usize).min(count - 1)];
            slice.0 += avatar.skin.measure[v] * map[v];
            slice.1 += avatar.skin.measure[v];
        }
        let filled = slices.iter().enumerate().filter(|(_, s)| s.1 > 0.0);
        filled
            .map(|(k, s)| {
                let middle = (k as f64 + 0.5) * SLICE - REACH;
                (1e3 * middle, s.0 / s.1)
            })
            .collect()
    }
}

/// I₁ − 2 = tr C − 2 at each vertex, C = FᵀF of the skin as a membrane, unposed: its triangles' by their areas.
fn first_invariant(avatar: &Avatar, state: &State) -> Vec<f64> {
    let (rest, now) = (&avatar.skin.position, unposed_skin(avatar, state).positions);
    let mut sums = vec![(0.0, 0.0); rest.len()];
    for t in &avatar.triangles {
        let edges = |x: &[DVec3]| {
            let [a, b, c] = t.map(|v| x[v as usize]);
            [b - a, c - a]
        };
        let ([a, b], [p, q]) = (edges(rest), edges(&now));
        // tr(G⁻¹ g) of the metrics G, g before and after.
        let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
        let determinant = aa * bb - ab * ab;
        let trace = (bb * p.dot(p) - 2.0 * ab * p.dot(q) + aa * q.dot(q)) / determinant;
        let area = 0.5 * determinant.sqrt();
        if determinant > 0.0 {
            for &v in t {
                sums[v as usize].0 += area * (trace - 2.0);
                sums[v as usize].1 += area;
            }
        }
    }
    sums.iter()
        .map(|(s, a)| s / a.max(f64::MIN_POSITIVE))
        .collect()
}

/// The value that a `share` of the absolute values lies below.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted: Vec<f64> = values.iter().map(|v| v.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::random_avatar;

    #[test]
    fn skin_that_does_not_move_is_not_strained() {
        let avatar = random_avatar(1, 2, 3, 20, 60);
        let map = first_invariant(&avatar, &avatar.rest_state());
        assert!(map.iter().all(|i| i.abs() < 1e-12));
    }
}
