//! A character of any file follows its own clip as a game would drive it, by the world matrices of its joints, while a
//! ball comes against it.
//!
//!     cargo run --release --example follow_clip -- character.glb out/follow_clip.png

mod picture;

use picture::Look;
use std::path::Path;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::Frame;
use supple::world::Backend;
use supple::{Error, Result, World};
use supple_files::{CharacterOptions, ClipOptions, ClipPlayer, read_character, read_gltf_motions};

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let usage = || Error::invalid("character", "name a glTF file with a clip");
    let character = arguments.next().ok_or_else(usage)?;
    let path = arguments.next().unwrap_or("out/follow_clip.png".into());

    let file = read_character(&character, &CharacterOptions::default())?;
    let recipe = supple_bake::Recipe::default();
    let (avatar, _) = supple_bake::bake(&file.body, &recipe, &mut |_| {})?;
    let clips = read_gltf_motions(&character)?;
    let clip = clips.into_iter().next().ok_or_else(usage)?;
    let player = ClipPlayer::new(clip, &avatar.skeleton, &ClipOptions::default())?;
    let joints = avatar.joints.clone();

    let mut world = World::new(Backend::Auto)?;
    let key = world.add_avatar(avatar)?;
    let key = world.add_instance(key)?;
    world.add_ground()?;
    let (mut matrices, mut pictures) = (Vec::new(), Vec::new());
    let start = player.frames(0.0);
    let centre = start.iter().map(|f| f.position).sum::<DVec3>() / start.len() as f64;
    let at = |time: f64| Frame {
        position: centre + DVec3::new(0.0, 0.0, 0.35 - 0.2 * time.min(1.0)),
        ..Frame::IDENTITY
    };
    let ball = world.add_collider(Collider::new(Shape::Sphere { radius: 0.1 }, at(0.0)))?;
    for frame in 0..90 {
        let time = f64::from(frame) / 60.0;
        // A game's animation gives these; here the clip's pose does.
        joints.joint_matrices(&player.frames(time), &mut matrices)?;
        let instance = world.instance_mut(key)?;
        instance.follow_world(&matrices)?;
        if frame == 0 {
            instance.reset();
        }
        world.collider_mut(ball)?.frame = at(time);
        world.step_blocking(1.0 / 60.0)?;
        if [0, 45, 89].contains(&frame) {
            let force = world.instance(key)?.report().contact_force.length();
            let collider = world.collider_mut(ball)?.clone();
            let look = Look {
                target: centre,
                from: DVec3::new(0.9, 0.25, 0.6),
                height: 2.0,
            };
            let image = picture::draw(&mut world, &[key], &[(&collider, at(time))], look)?;
            pictures.push((format!("{time:.1} s, {force:.1} N"), image));
        }
    }
    println!(
        "on {}, {:.2} ms a step",
        world.backend(),
        world.timings().step
    );
    picture::write(pictures, Path::new(&path))
}
