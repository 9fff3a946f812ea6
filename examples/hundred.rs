//! A hundred hands, each with a phase of its own, in one world.
//!
//!     cargo run --release --example hundred -- out/hundred.png

mod picture;

use picture::Look;
use std::path::Path;
use supple::glam::{DMat3, DVec3};
use supple::model::Frame;
use supple::world::Backend;
use supple::{Result, World};
use supple_samples::Sample;
use supple_scene::AvatarSource;

const ROW: usize = 10;
const APART: f64 = 0.25;

fn main() -> Result<()> {
    let path = std::env::args().nth(1).unwrap_or("out/hundred.png".into());
    let (body, recipe) = AvatarSource::of_sample(Sample::Hand).body()?;
    let (avatar, _) = supple_bake::bake(&body, &recipe, &mut |_| {})?;
    let mut world = World::new(Backend::Auto)?;
    let joints = avatar.skeleton.joints.clone();
    let hand = world.add_avatar(avatar)?;
    let hands: Vec<_> = (0..ROW * ROW)
        .map(|_| world.add_instance(hand))
        .collect::<Result<_>>()?;
    let look = Look {
        target: DVec3::new(1.1, 0.0, 1.1),
        from: DVec3::new(0.4, 1.0, 0.7),
        height: 3.0,
    };
    let (mut pictures, mut times) = (Vec::new(), Vec::new());
    for frame in 0..60 {
        let time = f64::from(frame) / 60.0;
        for (i, &hand) in hands.iter().enumerate() {
            let angle = 0.5 * (4.0 * time + 0.3 * i as f64).sin();
            let placement = Frame {
                rotation: DMat3::from_rotation_z(angle),
                position: APART * DVec3::new((i % ROW) as f64, 0.0, (i / ROW) as f64),
            };
            let instance = world.instance_mut(hand)?;
            if frame == 0 {
                instance.teleport_to(&placement)?;
            }
            let bone = |&joint: &DVec3| Frame {
                rotation: placement.rotation,
                position: placement.transform(joint),
            };
            let bones: Vec<_> = joints.iter().map(bone).collect();
            instance.follow_frames(&bones)?;
        }
        world.step_blocking(1.0 / 60.0)?;
        times.push(world.timings().step);
        if [0, 59].contains(&frame) {
            let image = picture::draw(&mut world, &hands, &[], look)?;
            pictures.push((format!("{time:.2} s"), image));
        }
    }
    times.sort_by(f64::total_cmp);
    println!(
        "{} hands on {}: {:.1} ms a step",
        hands.len(),
        world.backend(),
        times[times.len() / 2]
    );
    picture::write(pictures, Path::new(&path))
}
