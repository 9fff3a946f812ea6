//! A scene played: driven, stepped, measured and recorded.

mod driver;
mod full_space;
mod measure;
mod motion_driver;
mod report;
mod series;

pub use driver::Driver;
pub use full_space::{FullSpaceRun, run_full_space};
pub use report::{Breakdown, EnergyReport, Median, Report, Spread};

use crate::scene::{PanelTime, Scene};
use glam::DVec3;
use measure::Measures;
use serde::{Deserialize, Serialize};
use supple::Result;
use supple::internal::cpu::posed_skin;
use supple::model::{Avatar, Frame, State};
use supple::potential::Potential;
use supple::sim::{Simulation, StepReport};
use supple_files::{BoneMap, Prop, Recording, Series, from_srgb, solid_surface};

/// What a scene's run gave.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SceneRun {
    /// Its figures.
    pub report: Report,
    /// What each step told about itself.
    pub steps: Vec<StepReport>,
    /// Its motion.
    pub recording: Recording,
    /// Which bones of its motion drove which of the avatar, if it has one.
    pub bone_map: Option<BoneMap>,
    /// What its pictures show.
    pub snapshots: Vec<Snapshot>,
}

/// A moment that is drawn.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    /// Its caption and what it shows.
    pub panel: PanelTime,
    /// Drawn skin, m.
    pub skin: Vec<DVec3>,
    /// Unposed displacement of each skin vertex, m.
    pub displacement: Vec<DVec3>,
    /// A frame for each collider.
    pub colliders: Vec<Frame>,
    /// A frame for each body.
    pub bodies: Vec<Frame>,
}

/// Plays `scene` with one instance; `progress` is called with the number of steps made.
///
/// # Errors
/// A bone that the avatar does not have, and whatever a step says.
pub fn run_scene<P: Potential>(
    scene: &Scene,
    avatar: &Avatar,
    simulation: &mut Simulation<P>,
    progress: &mut dyn FnMut(usize),
) -> Result<SceneRun> {
    play(scene, avatar, simulation, None, progress)
}

/// [`run_scene`] with every step kept as arrays: skin, displacement, contact forces, loads and energies. It takes 72 bytes a
/// vertex and step. Where no bone is pinned, loads and energies are of the step's end only with
/// [`Settings::report_at_end`](supple::sim::Settings::report_at_end).
///
/// # Errors
/// As [`run_scene`].
pub fn run_scene_as_series<P: Potential>(
    scene: &Scene,
    avatar: &Avatar,
    simulation: &mut Simulation<P>,
    progress: &mut dyn FnMut(usize),
) -> Result<(SceneRun, Series)> {
    let mut series = series::empty(avatar);
    let run = play(scene, avatar, simulation, Some(&mut series), progress)?;
    Ok((run, series))
}

fn play<P: Potential>(
    scene: &Scene,
    avatar: &Avatar,
    simulation: &mut Simulation<P>,
    mut series: Option<&mut Series>,
    progress: &mut dyn FnMut(usize),
) -> Result<SceneRun> {
    let mut driver = Driver::new(scene, avatar)?;
    driver.start(avatar, &mut simulation.instances_mut()[0]);
    if scene.settle {
        simulation.settle_blocking()?;
    }
    driver.launch(avatar, &mut simulation.instances_mut()[0]);
    let mut measures = Measures::new(scene, avatar);
    let mut recording = Recording {
        up: scene.up(),
        props: props(scene),
        ..Recording::default()
    };
    let mut snapshots = vec![None; scene.output.panels.len()];
    let start = &simulation.instances()[0].state;
    record(&mut recording, &driver, 0.0, start);
    measures.start(start);
    let (mut skin, mut normals) = (posed_skin(avatar, start).positions, Vec::new());
    let mut draw =
        |step: usize, skin: &[DVec3], displacement: &[DVec3], state: &State, driver: &Driver| {
            let time = step as f64 * scene.settings.time_step;
            for (panel, snapshot) in scene.output.panels.iter().zip(&mut snapshots) {
                if scene.step_at(panel.time) == step {
                    *snapshot = Some(Snapshot {
                        panel: panel.clone(),
                        skin: skin.to_vec(),
                        displacement: displacement.to_vec(),
                        colliders: driver.collider_frames(time).collect(),
                        bodies: state.frames[avatar.bones()..].to_vec(),
                    });
                }
            }
        };
    draw(0, &skin, measures.displacement(), start, &driver);
    for step in 1..=scene.steps {
        let time = step as f64 * scene.settings.time_step;
        driver.drive(time, &mut simulation.instances_mut()[0])?;
        let report = simulation.step_blocking()?;
        simulation.read_skin_blocking(0, &mut skin, &mut normals)?;
        measures.add(step, &report, &simulation.instances()[0], &skin);
        if let Some(series) = &mut series {
            let shown = (&skin[..], measures.displacement());
            series::add(series, avatar, simulation, time, &report, shown)?;
        }
        let instance = &simulation.instances()[0];
        if step % scene.output.record_every == 0 || step == scene.steps {
            record(&mut recording, &driver, time, &instance.state);
        }
        draw(
            step,
            &skin,
            measures.displacement(),
            &instance.state,
            &driver,
        );
        progress(step);
    }
    let steps = measures.steps().to_vec();
    Ok(SceneRun {
        steps,
        report: Report {
            motion_notes: driver.motion_notes().to_vec(),
            ..measures.report(avatar, simulation.potential().name())
        },
        recording,
        bone_map: driver.bone_map().cloned(),
        snapshots: snapshots.into_iter().flatten().collect(),
    })
}

fn record(recording: &mut Recording, driver: &Driver, time: f64, state: &State) {
    recording.times.push(time);
    recording.states.push(state.clone());
    for (prop, frame) in recording.props.iter_mut().zip(driver.collider_frames(time)) {
        prop.frames.push(frame);
    }
}

/// Half the side of the square that stands for a half-space, m.
pub const HALF_SPACE_EXTENT: f64 = 0.3;
/// What colliders look like.
pub const COLLIDER_COLOUR: u32 = 0x8fa3b8;

fn props(scene: &Scene) -> Vec<Prop> {
    let colour = from_srgb(COLLIDER_COLOUR);
    let prop = |c: &crate::scene::SceneCollider| Prop {
        name: c.name.clone(),
        surface: solid_surface(&c.shape, HALF_SPACE_EXTENT),
        colour,
        frames: Vec::new(),
    };
    scene.colliders.iter().map(prop).collect()
}
