//! A game that shares its wgpu device: two soft hands stepped together, drawn with no readback.
//!
//! `cargo run --release --example shared_device`

use std::sync::Arc;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::potential::{GpuOptions, GpuPotential};
use supple::sim::{Settings, Simulation};
use supple::skeleton::Tracking;
use supple_samples::Sample;
use supple_scene::AvatarSource;

fn main() -> supple::Result<()> {
    // A game has these already; make its device with `supple::gpu::required_limits()`.
    let GpuDevice {
        device,
        queue,
        adapter,
    } = pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware))?;

    let (body, recipe) = AvatarSource::of_sample(Sample::Hand).body()?;
    let (avatar, _) = supple_bake::bake(&body, &recipe, &mut |_| {})?; // once; or file::read_avatar(path)
    let avatar = Arc::new(avatar);
    let hands = GpuPotential::new(&device, &queue, avatar.clone(), 2, GpuOptions::default())?;
    let mut simulation = Simulation::new(&avatar, hands, Settings::default())?;
    for hand in simulation.instances_mut() {
        hand.targets.push(Tracking::new(0, hand.state.frames[0])); // a spring holds the wrist
    }
    for _frame in 0..60 {
        // What the tracker or the animation says; colliders go into `colliders`.
        simulation.instances_mut()[0].targets[0].frame.position.z -= 0.001;
        simulation.step_blocking()?; // or `simulation.step().await`
        let hands = simulation.potential();
        let (_vertices, _bytes) = (hands.skin_buffer(), hands.skin_range(0)); // set_vertex_buffer
        let _origin = hands.skin_origin(0); // positions are relative to it: translate by it
    }
    println!("60 frames of two hands on {}", adapter.name);
    Ok(())
}
