//! Every character file there is, baked with no recipe: its static pose is the file's own skinning, and a shake
//! moves its tissue visibly and inverts nothing.

mod support;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use supple::bake::bake;
use supple::glam::DVec3;
use supple::load::avatar_source_of;
use supple::model::Avatar;
use supple::reference::{Reference, min_det_f};
use supple::sim::{Pin, Settings, Simulation};

const FOLDER: &str = "../shared/assets";

fn characters() -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(FOLDER) else {
        return Vec::new();
    };
    let mut out: Vec<PathBuf> = entries
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "glb" || e == "npz"))
        .collect();
    out.sort();
    out
}

fn shake(avatar: &Avatar, mode: usize) -> (f64, f64, f64) {
    let avatar = Arc::new(avatar.clone());
    let potential = Reference::new(avatar.clone(), 1, 0).unwrap();
    let mut simulation = Simulation::new(&avatar, potential, Settings::default()).unwrap();
    let rest = avatar.rest_state();
    let (mut peak, mut least, mut gap) = (0f64, 1f64, 0f64);
    for step in 1..=200 {
        let t = step as f64 * 0.01;
        let offset = (if mode == 2 { DVec3::Y } else { DVec3::X }) * 0.05 * (2.0 * std::f64::consts::PI * 3.0 * t).sin();
        let instance = &mut simulation.instances_mut()[0];
        instance.pins = (0..if mode == 0 { 1 } else { rest.frames.len() })
            .map(|bone| {
                let mut frame = rest.frames[bone];
                frame.position += offset;
                Pin { bone, frame }
            })
            .collect();
        let report = simulation.step_blocking().unwrap();
        gap = gap.max(report.instances[0].max_joint_gap);
        let state = &simulation.instances()[0].state;
        for row in avatar.skin.basis.iter() {
            let u: DVec3 = row
                .iter()
                .map(|u| u.value * state.handles[u.handle as usize])
                .sum();
            peak = peak.max(u.length());
        }
        least = least.min(min_det_f(&avatar.layer, state));
    }
    (peak * 1e3, least, gap * 1e3)
}

#[test]
fn experiment() {
    for path in characters() {
        let only = std::env::var("ONLY").unwrap_or_default();
        if !path.to_string_lossy().contains(&only) {
            continue;
        }
        run(&path);
    }
}

fn run(path: &Path) {
    println!("== {}", path.display());
    let since = std::time::Instant::now();
    let baked = avatar_source_of(path)
        .and_then(|s| s.body())
        .and_then(|(body, recipe)| bake(&body, &recipe, &mut |_| {}));
    match baked {
        Err(e) => println!("error {e}"),
        Ok((avatar, report)) => {
            println!(
                "{:.1} s; {:?} {} handles {} points {} tets {:?}",
                since.elapsed().as_secs_f64(),
                avatar.material,
                avatar.handles.len(),
                avatar.cubature.len(),
                report.mesh.quality.tets,
                report.cost.seconds
            );
            println!(
                "bones {:.2} kg tissue {:.2} kg",
                report.bones.total, report.tissue_mass
            );
            for mode in [1, 2, 0] {
                let since = std::time::Instant::now();
                println!(
                    "mode {mode}: {:?} in {:.1} s",
                    shake(&avatar, mode),
                    since.elapsed().as_secs_f64()
                );
            }
        }
    }
}
