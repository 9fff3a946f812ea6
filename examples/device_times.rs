//! What a hand-sized avatar (357 DoFs, 700 cubature points, 3,100 skin vertices) costs on the device, step by
//! step and stage by stage: `cargo run --release --example device_times [points]`.

use std::sync::Arc;
use std::time::Instant;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::internal::{random_avatar, random_state};
use supple::model::{Frame, InertialTarget, State};
use supple::potential::{
    Evaluation, GpuOptions, GpuPotential, Potential, StepStart, TissueFactors,
};

const STEPS: usize = 200;

fn main() -> supple::Result<()> {
    let points = std::env::args().nth(1).and_then(|n| n.parse().ok());
    let gpu = pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware))?;
    let avatar = Arc::new(random_avatar(1, 16, 87, points.unwrap_or(700), 3100));
    let options = GpuOptions::default();
    let mut potential = GpuPotential::new(&gpu.device, &gpu.queue, avatar.clone(), 1, options)?;

    // A plane that some tenth of the skin touches, as a hand on a table does.
    let frame = Frame {
        position: DVec3::new(0.0, 0.0, -0.0205),
        ..Frame::IDENTITY
    };
    let colliders = [Collider {
        margin: 1e-3,
        ..Collider::new(Shape::HalfSpace, frame)
    }];
    let step = vec![1e-5; avatar.space().dofs()];
    let mut states: [State; 3] = {
        let first = random_state(1, &avatar, 0.3, 0.001);
        let second = first.moved(&step, 1.0);
        [first, second.clone(), second.moved(&step, 1.0)]
    };
    let mut out = [Evaluation::default()];
    let mut times = Vec::new();
    for k in 0..STEPS {
        let clock = Instant::now();
        let [previous, current, next] = &states;
        let start = StepStart {
            time_step: 0.01,
            inertia: InertialTarget::backward_euler(previous, 0.01),
            current,
            colliders: &colliders,
            tissue_gravity: DVec3::ZERO,
            slip_speed: 1e-3,
            geometric_contact: false,
            factors: TissueFactors::default(),
            pose_offsets: &[],
            prescribed: &[],
        };
        pollster::block_on(async {
            potential.begin_step(&[start], &[true]).await?;
            let next = std::slice::from_ref(next);
            potential.evaluate(next, &[true], &mut out).await?;
            potential.pose_skin(next, &[], &[]).await
        })?;
        times.push(1e3 * clock.elapsed().as_secs_f64());
        let sign = if k % 100 < 50 { 1.0 } else { -1.0 };
        let moved = states[2].moved(&step, sign);
        states.rotate_left(1);
        states[2] = moved;
    }
    // The first steps compile kernels.
    let times = &mut times[20..];
    times.sort_by(f64::total_cmp);
    println!(
        "{}: {} DoFs, {} points, {} contacts, {} blocks",
        potential.name(),
        avatar.space().dofs(),
        avatar.cubature.len(),
        out[0].contacts,
        potential.pattern().len()
    );
    println!(
        "begin_step + evaluate + pose_skin: median {:.2} ms, least {:.2} ms",
        times[times.len() / 2],
        times[0]
    );
    for (stage, seconds) in pollster::block_on(potential.stage_times(50))? {
        println!("  {stage:<16} {:8.3} ms", 1e3 * seconds);
    }
    Ok(())
}
