//! `supple-web-reference FOLDER`: what the tests of the npm package compare the wasm with. The sample hand as a baked file, and
//! the scene `hand_press` played natively on one thread through the layer below a world: targets and colliders of each step as
//! JSON, the skin at some steps in f32, milliseconds a step.

use glam::{DMat4, DQuat, DVec3};
use serde_json::json;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use supple::file::Parts;
use supple::model::Frame;
use supple::potential::CpuPotential;
use supple::sim::Simulation;
use supple_bake::{bake, baked_file};
use supple_scene::{Driver, read_scene};

/// Steps between two skins that are kept.
const EVERY: usize = 50;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("which folder?")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let scene = read_scene(root.join("assets/scenes/hand_press.toml"))?;
    let (body, recipe) = scene.avatar.body()?;
    let (mut avatar, report) = bake(&body, &recipe, &mut |_| {})?;
    baked_file(&avatar, Some(&report))?.write(Parts::Step, folder.join("hand.supple"))?;
    scene.dress(&mut avatar)?;
    let avatar = Arc::new(avatar);

    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = Simulation::new(&avatar, potential, scene.settings)?;
    let mut driver = Driver::new(&scene, &avatar)?;
    driver.start(&avatar, &mut simulation.instances_mut()[0]);
    simulation.settle_blocking()?;
    driver.launch(&avatar, &mut simulation.instances_mut()[0]);

    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    let (mut targets, mut samples, mut kept) = (Vec::new(), Vec::new(), Vec::new());
    let (mut times, mut forces) = (Vec::new(), Vec::new());
    let target = |simulation: &Simulation<CpuPotential>| {
        let target = &simulation.instances()[0].targets[0];
        let joint = (avatar.joints.joints().iter()).find(|j| j.bone.bone() == target.bone);
        let bind = joint.map_or(DMat4::IDENTITY, |j| j.bind.into());
        let matrix = matrix(&target.frame) * bind;
        json!({ "joint": joint.map(|j| &j.name), "matrix": matrix.to_cols_array() })
    };
    targets.push(target(&simulation));
    for step in 1..=scene.steps {
        let time = step as f64 * scene.settings.time_step;
        driver.drive(time, &mut simulation.instances_mut()[0])?;
        targets.push(target(&simulation));
        let watch = Instant::now();
        let report = simulation.step_blocking()?;
        simulation.read_skin_blocking(0, &mut skin, &mut normals)?;
        times.push(watch.elapsed().as_secs_f64() * 1e3);
        forces.push(report.instances[0].contact_force.length());
        if step % EVERY == 0 {
            samples.push(step);
            kept.extend(skin.iter().flat_map(|p| p.as_vec3().to_array()));
        }
    }

    let colliders = driver.collider_frames(0.0).zip(&scene.colliders);
    let colliders = colliders.map(|(frame, collider)| {
        json!({
            "shape": *collider.shape,
            "position": frame.position.to_array(),
            "rotation": DQuat::from_mat3(&frame.rotation).to_array(),
            "stiffness": collider.stiffness,
            "friction": collider.friction,
            "margin": collider.margin,
        })
    });
    let told = json!({
        "dt": scene.settings.time_step,
        "steps": scene.steps,
        "bending": scene.settings.bending_stiffness,
        "bendingDamping": scene.settings.bending_stiffness * scene.settings.joint_damping_time,
        "rotation": scene.targets[0].rotation,
        "position": scene.targets[0].position,
        "targets": targets,
        "colliders": colliders.collect::<Vec<_>>(),
        "samples": samples,
        "vertices": skin.len(),
        "largestForce": forces.iter().copied().fold(0.0, f64::max),
        "milliseconds": times,
    });
    std::fs::write(folder.join("hand_press.json"), told.to_string())?;
    let bytes: Vec<u8> = kept.iter().flat_map(|x: &f32| x.to_le_bytes()).collect();
    std::fs::write(folder.join("hand_press.f32"), bytes)?;
    times.sort_by(f64::total_cmp);
    println!(
        "native, one thread: {:.2} ms a step (median)",
        times[times.len() / 2]
    );
    Ok(())
}

fn matrix(frame: &Frame) -> DMat4 {
    let rotation = DQuat::from_mat3(&frame.rotation);
    DMat4::from_scale_rotation_translation(DVec3::ONE, rotation, frame.position)
}
