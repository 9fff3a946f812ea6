//! A hand is pressed by a ball: on the CPU, or on a GPU that is shared with the host.
//!
//!     cargo run --release --example press -- cpu out/press.png
//!     cargo run --release --example press -- gpu out/press.png

mod picture;

use picture::Look;
use std::path::Path;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::model::Frame;
use supple::world::Backend;
use supple::{Result, World};
use supple_samples::Sample;
use supple_scene::AvatarSource;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let backend = match arguments.next().as_deref() {
        Some("gpu") => {
            // A game has these already; make its device with `supple::gpu::required_limits()`.
            let opened = GpuDevice::open(AdapterChoice::HardwareElseSoftware);
            let GpuDevice { device, queue, .. } = pollster::block_on(opened)?;
            Backend::Gpu { device, queue }
        }
        _ => Backend::Cpu,
    };
    let path = arguments.next().unwrap_or("out/press.png".into());

    // Once; a game reads what `supple bake` has written, by `supple::file::read_avatar`.
    let (body, recipe) = AvatarSource::of_sample(Sample::Hand).body()?;
    let (avatar, _) = supple_bake::bake(&body, &recipe, &mut |_| {})?;
    // The highest vertex of the palm's side, above which the ball comes down.
    let top = avatar.skin.position.iter().copied();
    let top = top.fold(DVec3::NEG_INFINITY, |a, b| if b.y > a.y { b } else { a });

    let mut world = World::new(backend)?;
    let hand = world.add_avatar(avatar)?;
    let hand = world.add_instance(hand)?;
    let radius = 0.02;
    let at = |depth: f64| Frame {
        position: top + (radius - depth) * DVec3::Y,
        ..Frame::IDENTITY
    };
    let ball = world.add_collider(Collider::new(Shape::Sphere { radius }, at(-0.01)))?;
    let look = Look {
        target: top - 0.02 * DVec3::Y,
        from: DVec3::new(0.9, 0.35, 0.5),
        height: 0.16,
    };
    let mut pictures = Vec::new();
    for frame in 0..60 {
        let depth = -0.01 + 0.018 * f64::from(frame.min(40)) / 40.0;
        world.collider_mut(ball)?.frame = at(depth);
        world.step_blocking(1.0 / 60.0)?;
        if [0, 30, 59].contains(&frame) {
            let force = world.instance(hand)?.report().contact_force.length();
            let collider = world.collider_mut(ball)?.clone();
            let image = picture::draw(&mut world, &[hand], &[(&collider, at(depth))], look)?;
            pictures.push((format!("{force:.1} N"), image));
        }
    }
    println!(
        "on {}, {:.2} ms a step",
        world.backend(),
        world.timings().step
    );
    picture::write(pictures, Path::new(&path))
}
