//! A box is held between two hands of different assets: one system moves all three.
//!
//!     cargo run --release --example box_between -- out/box_between.png

mod picture;

use picture::Look;
use std::path::Path;
use supple::collider::Shape;
use supple::glam::{DMat3, DVec3};
use supple::model::{Frame, RigidBody};
use supple::world::Backend;
use supple::{Result, World};
use supple_samples::Sample;
use supple_scene::AvatarSource;

fn main() -> Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or("out/box_between.png".into());
    let bake = |sample| -> Result<_> {
        let (body, recipe) = AvatarSource::of_sample(sample).body()?;
        Ok(supple_bake::bake(&body, &recipe, &mut |_| {})?.0)
    };
    let avatars = [bake(Sample::Hand)?, bake(Sample::Finger)?];
    let mut world = World::new(Backend::Auto)?;
    // Each stands with its highest vertex below the box, the second one turned over above it.
    let half = 0.02;
    let mut frames = Vec::new();
    let mut keys = Vec::new();
    for (avatar, turn) in avatars.into_iter().zip([0.0, std::f64::consts::PI]) {
        let top = avatar.skin.position.iter().copied();
        let top = top.fold(DVec3::NEG_INFINITY, |a, b| if b.y > a.y { b } else { a });
        let rotation = DMat3::from_rotation_z(turn);
        let outward = rotation * DVec3::Y;
        frames.push((rotation, -(rotation * top), outward));
        let key = world.add_avatar(avatar)?;
        keys.push(world.add_instance(key)?);
    }
    let place = |(rotation, origin, outward): (DMat3, DVec3, DVec3), gap: f64| Frame {
        rotation,
        position: origin - (half + gap) * outward,
    };
    let solid = Shape::Box {
        half_extents: [0.03, half, 0.03],
    };
    let body = RigidBody::new("box", solid, 200.0)?.at(Frame::IDENTITY);
    let (collider, body) = (body.collider(0), world.add_body(body)?);
    world.set_gravity(DVec3::ZERO);
    let look = Look {
        target: DVec3::ZERO,
        from: DVec3::new(0.3, 0.2, 1.0),
        height: 0.3,
    };
    let mut pictures = Vec::new();
    for frame in 0..90 {
        let gap = 0.003 - 0.006 * f64::from(frame.min(60)) / 60.0;
        for (key, &at) in keys.iter().zip(&frames) {
            let placement = place(at, gap);
            let instance = world.instance_mut(*key)?;
            let joints = &instance.avatar().skeleton.joints;
            let bones: Vec<_> = joints[..instance.frames().len()]
                .iter()
                .map(|&joint| Frame {
                    rotation: placement.rotation,
                    position: placement.transform(joint),
                })
                .collect();
            if frame == 0 {
                instance.teleport_to(&placement)?;
            }
            instance.follow_frames(&bones)?;
        }
        world.step_blocking(1.0 / 60.0)?;
        if [0, 45, 89].contains(&frame) {
            let force = |key| -> Result<f64> { Ok(world.instance(key)?.report().contact_force.y) };
            let caption = format!("{:.2} N, {:.2} N", force(keys[0])?, force(keys[1])?);
            let at = world.body_frame(body)?;
            pictures.push((
                caption,
                picture::draw(&mut world, &keys, &[(&collider, at)], look)?,
            ));
        }
    }
    println!(
        "on {}, {:.2} ms a step",
        world.backend(),
        world.timings().step
    );
    picture::write(pictures, Path::new(&path))
}
