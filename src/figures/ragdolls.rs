//! Two bodies of different shape that hang limply and are pushed.

use super::{Bound, Curves, Figure, Page, Studio};
use crate::Result;
use crate::model::{Avatar, State};
use crate::reference::displacement::position;
use glam::{DMat3, DVec3};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "ragdolls",
    title: "Ragdolls pushed by a bar",
    paper: "figure 12",
    draw,
};

/// A body and a heavier one hang by their wrists; a bar pushes both alike and leaves. Joints and their limits hold
/// them together, their shapes make them swing differently, and nothing makes energy.
fn draw(studio: &Studio) -> Result<Page> {
    let mut scene = studio.scene("ragdolls")?;
    let bar = &scene.colliders[0].motion.y;
    let (touch, leave) = (bar[0][0], bar[bar.len() - 1][0]);
    let mut page = Page::new(
        "Two bodies of different shape hang by their wrists, limp but for a little bending stiffness and the ranges of \
         their joints. A bar pushes both alike and is withdrawn.",
    );
    let mut swings: Vec<(&str, Vec<(f64, f64)>)> = Vec::new();
    let mut energies: Vec<(&str, Vec<(f64, f64)>)> = Vec::new();
    let heavy = std::mem::take(&mut scene.avatar.betas);
    for (name, betas) in [("lean", vec![]), ("heavy", heavy)] {
        scene.avatar.betas = betas;
        let avatar = studio.avatar_of(&scene)?;
        let run = studio.play(&scene, &avatar)?;
        page.picture(
            name,
            studio.strip(&scene, &avatar, &run),
            format!("the {name} body"),
        );
        let (times, states) = (&run.recording.times, &run.recording.states);
        let pelvis = |s: &State| 1e3 * (s.frames[0].position - states[0].frames[0].position).y;
        swings.push((
            name,
            times
                .iter()
                .zip(states)
                .map(|(t, s)| (*t, pelvis(s)))
                .collect(),
        ));
        let pairs = states.windows(2).zip(&times[1..]);
        let energy: Vec<(f64, f64)> = pairs
            .map(|(s, t)| {
                let h = scene.settings.time_step;
                (*t, mechanical(&avatar, &s[0], &s[1], h, scene.gravity))
            })
            .collect();
        // What the bar has done by the time it has gone is all there is.
        let after: Vec<f64> = energy.iter().filter(|e| e.0 > leave).map(|e| e.1).collect();
        let (least, most) = (energy.iter())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), e| {
                (a.min(e.1), b.max(e.1))
            });
        let rise = after.iter().fold(0.0, |a: f64, e| a.max(e - after[0]));
        page.check(
            format!("energy that the {name} body gains when the bar has gone, of its range"),
            rise / (most - least),
            "",
            Bound::AtMost(0.02),
        );
        page.check_intact(&format!(" of the {name} body"), &run.report);
        energies.push((name, energy));
    }
    let pushed = |swing: &[(f64, f64)]| -> Vec<f64> {
        swing.iter().filter(|s| s.0 > touch).map(|s| s.1).collect()
    };
    let (lean, heavy) = (pushed(&swings[0].1), pushed(&swings[1].1));
    let far = |swing: &[f64]| swing.iter().fold(0.0, |a: f64, s| a.max(s.abs()));
    let apart = (lean.iter().zip(&heavy))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    page.check(
        "the pelvis is pushed by",
        far(&lean).min(far(&heavy)),
        "mm",
        Bound::AtLeast(50.0),
    );
    page.check("the two swings differ by", apart, "mm", Bound::AtLeast(5.0));
    let mut swing = Curves::new("Pelvis, away from the bar", "time (s)", "mm");
    for (name, curve) in swings {
        swing = swing.line(name, curve);
    }
    page.curves(swing);
    let mut energy = Curves::new("Kinetic and gravitational energy", "time (s)", "J");
    for (name, curve) in energies {
        energy = energy.line(name, curve);
    }
    page.curves(energy);
    Ok(page)
}

/// Kinetic energy of bones and tissue on the way from one state to the next, and their energy under gravity, J.
fn mechanical(avatar: &Avatar, before: &State, after: &State, h: f64, gravity: DVec3) -> f64 {
    let mut energy = 0.0;
    for (j, bone) in avatar.bone_masses.iter().enumerate() {
        let s = &bone.second_moment;
        let column = |k: usize| DVec3::new(s[0][k], s[1][k], s[2][k]);
        let second = DMat3::from_cols(column(0), column(1), column(2));
        let (mass, first) = bone.moments();
        let (a, b) = (&before.frames[j], &after.frames[j]);
        let turn = (b.rotation - a.rotation) * h.recip();
        let velocity = (b.position - a.position) / h;
        // ½ tr(Ȧ S Ȧᵀ), A = [R | c].
        let turned = turn * second;
        let rotation: f64 = (0..3).map(|k| turned.col(k).dot(turn.col(k))).sum();
        let mixed = velocity.dot(turn * first);
        energy += 0.5 * rotation + mixed + 0.5 * mass * velocity.length_squared();
        energy -= gravity.dot(b.rotation * first + mass * b.position);
    }
    let (points, joints) = (&avatar.cubature, &avatar.skeleton.joints);
    for i in 0..points.len() {
        let at = |s: &State| {
            position(
                points.skinning.row(i),
                joints,
                &s.frames,
                points.position[i],
            )
        };
        let (a, b) = (at(before), at(after));
        let mass = avatar.density * points.measure[i];
        energy += mass * (0.5 * (b - a).length_squared() / (h * h) - gravity.dot(b));
    }
    energy
}
