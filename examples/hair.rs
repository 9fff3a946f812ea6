//! The sample body with hair and a skirt on 180 spring bones, as VRM avatars have them, walks: what a step costs with them and
//! without, and what it looks like.
//!
//!     cargo run --release --example hair -- out/hair.png

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;
use supple::glam::{DMat3, DVec3};
use supple::model::{
    Avatar, BoneMass, JointList, PoseBlend, SkinWeight, SpringChain, SpringCollider, SpringJoint,
    Surface, UpAxis,
};
use supple::sim::SpringMode;
use supple::skeleton::Spring;
use supple::world::{Backend, InstanceId};
use supple::{Result, World};
use supple_bake::{Attachment, Body, bake};
use supple_files::{ClipOptions, ClipPlayer, RetargetOptions};
use supple_pictures::{Camera, Mesh, Panel, Projection, Strip, View, from_srgb, render};
use supple_samples::{Sample, walk};

const STRANDS: usize = 20;
const OF_STRAND: usize = 6;
const PLEATS: usize = 12;
const OF_PLEAT: usize = 5;

/// A row of joints that hangs on a bone of the body, and the cloth around it.
struct Row {
    on: &'static str,
    points: Vec<DVec3>,
    /// Half the width of the cloth, m.
    half_width: f64,
    like: SpringJoint,
    chain: usize,
}

impl Row {
    /// Hangs it on `body`: on bones of its own that swing, or all on the bone that carries it.
    fn hang(&self, body: &mut Body, swings: bool) {
        let skeleton = &mut body.skeleton;
        let carrier = skeleton.find(self.on).unwrap_or(0) as u32;
        let first = skeleton.len() as u32;
        let joints = self.points.len() - 1;
        for k in (0..joints).filter(|_| swings) {
            let bone = first + k as u32;
            skeleton.names.push(format!("row {first} {k}"));
            skeleton
                .parents
                .push(Some(if k > 0 { bone - 1 } else { carrier }));
            skeleton.joints.push(self.points[k]);
            body.springs.joints.push(SpringJoint {
                chain: self.chain as u32,
                bone,
                tail: self.points[k + 1] - self.points[k],
                ..self.like
            });
        }
        let bone = |k: usize| if swings { first + k as u32 } else { carrier };
        let middle = 0.5 * (self.points[0] + self.points[joints]);
        let outward = (middle - skeleton.joints[carrier as usize])
            .with_y(0.0)
            .normalize_or(DVec3::Z);
        let side = outward.cross(DVec3::Y);
        let mut cloth = Attachment {
            name: self.on.into(),
            ..Attachment::default()
        };
        let surface = &mut cloth.surface;
        for (k, point) in self.points.iter().enumerate() {
            let narrow = 1.0
                - 0.6 * (k as f64 / joints as f64) * f64::from(u8::from(self.half_width < 0.03));
            for corner in [-side, outward * 0.5, side, -outward * 0.5] {
                surface
                    .positions
                    .push(*point + self.half_width * narrow * corner);
                let half = |bone| SkinWeight { bone, weight: 0.5 };
                let (above, below) = (bone(k.saturating_sub(1)), bone(k.min(joints - 1)));
                let row = if above == below {
                    vec![SkinWeight {
                        bone: above,
                        weight: 1.0,
                    }]
                } else {
                    vec![half(above), half(below)]
                };
                cloth.skinning.push(row);
            }
        }
        for v in (0..4 * joints as u32).map(|v| (v, v / 4 * 4 + (v + 1) % 4)) {
            let (a, b) = v;
            surface.triangles.extend([[a, b, a + 4], [b, b + 4, a + 4]]);
        }
        body.attachments.push(cloth);
    }
}

/// The sample body, with hair and skirt on bones of their own where they swing.
fn avatar(swings: bool) -> Result<Avatar> {
    let (mut body, recipe) = Sample::Body.body()?;
    // A glTF file has no blend shapes of the pose; they would give every bone a say.
    body.pose_blend = PoseBlend::default();
    let joint = |name: &str| body.skeleton.joints[body.skeleton.find(name).unwrap_or(0)];
    let (head, pelvis) = (joint("head"), joint("pelvis"));
    let (_, top) = body.skin.bounds();
    let crown = DVec3::new(head.x, top.y, head.z);
    let like = SpringJoint {
        chain: 0,
        bone: 0,
        tail: DVec3::ZERO,
        rest_rotation: DMat3::IDENTITY,
        stiffness: 0.8,
        drag_force: 0.3,
        gravity: DVec3::NEG_Y * 0.5,
        hit_radius: 0.015,
    };
    let mut rows = Vec::new();
    for k in 0..STRANDS {
        // Around the head but for the face.
        let angle = TAU * (0.18 + 0.64 * k as f64 / (STRANDS - 1) as f64);
        let out = DVec3::new(angle.sin(), 0.0, angle.cos());
        let root = crown - DVec3::Y * 0.06 + 0.085 * out;
        let points = (0..=OF_STRAND).map(|i| {
            let down = 0.085 * i as f64;
            root - DVec3::Y * down + out * 0.02 * (1.0 - (-6.0 * down).exp())
        });
        rows.push(Row {
            on: "head",
            points: points.collect(),
            half_width: 0.018,
            like,
            chain: rows.len(),
        });
    }
    for k in 0..PLEATS {
        let angle = TAU * k as f64 / PLEATS as f64;
        let out = DVec3::new(angle.sin(), 0.0, 0.8 * angle.cos());
        let points = (0..=OF_PLEAT).map(|i| {
            let down = 0.09 * i as f64;
            pelvis + DVec3::Y * (0.05 - down) + out * (0.17 + 0.35 * down)
        });
        rows.push(Row {
            on: "pelvis",
            points: points.collect(),
            half_width: 0.07,
            like: SpringJoint {
                stiffness: 1.2,
                hit_radius: 0.03,
                ..like
            },
            chain: rows.len(),
        });
    }
    // What a VRM has in its collider groups: head, trunk, thighs and shins.
    let limbs = [
        ("head", crown - head - DVec3::Y * 0.09, None, 0.085),
        ("neck", DVec3::NEG_Y * 0.02, None, 0.06),
        ("spine3", DVec3::ZERO, Some(DVec3::Y * 0.1), 0.11),
        (
            "left_hip",
            DVec3::ZERO,
            Some(joint("left_knee") - joint("left_hip")),
            0.075,
        ),
        (
            "right_hip",
            DVec3::ZERO,
            Some(joint("right_knee") - joint("right_hip")),
            0.075,
        ),
        (
            "left_knee",
            DVec3::ZERO,
            Some(joint("left_ankle") - joint("left_knee")),
            0.055,
        ),
        (
            "right_knee",
            DVec3::ZERO,
            Some(joint("right_ankle") - joint("right_knee")),
            0.055,
        ),
    ];
    let collider =
        |&(name, offset, tail, radius): &(&str, DVec3, Option<DVec3>, f64)| SpringCollider {
            bone: body.skeleton.find(name).unwrap_or(0) as u32,
            offset,
            tail,
            radius,
        };
    let colliders: Vec<_> = limbs.iter().map(collider).collect();
    if swings {
        body.springs.colliders = colliders;
        body.springs.chains = (rows.iter())
            .map(|row| SpringChain {
                name: row.on.into(),
                center: None,
                colliders: if row.on == "head" {
                    vec![0, 1, 2]
                } else {
                    vec![3, 4, 5, 6]
                },
            })
            .collect();
    }
    rows.iter().for_each(|row| row.hang(&mut body, swings));
    body.joints = JointList::of_bones(&body.skeleton);
    let (avatar, report) = bake(&body, &recipe, &mut |_| {})?;
    let carried = avatar
        .bone_masses
        .iter()
        .filter(|m| **m == BoneMass::NONE)
        .count();
    println!(
        "{} bones, {carried} of them carried; {}; {} handles",
        avatar.skeleton.len(),
        report.springs,
        avatar.handles.len()
    );
    Ok(avatar)
}

/// Walks for three seconds; the median of the steps' times, ms. Bones are tracked by springs, or follow exactly.
fn run(avatar: &Arc<Avatar>, tracked: bool, strip: Option<&mut Strip>) -> Result<f64> {
    let options = ClipOptions {
        retarget: RetargetOptions {
            avatar_up: Some(UpAxis::Y),
            up: DVec3::Y,
            ..RetargetOptions::default()
        },
        repeat: true,
        ..ClipOptions::default()
    };
    let mut player = ClipPlayer::new(walk(), &avatar.skeleton, &options)?;
    player.stand_at(&avatar.rest_state().frames);
    let mut world = World::new(Backend::Cpu)?;
    let key = world.add_avatar(avatar.clone())?;
    let key = world.add_instance(key)?;
    // The clip has nothing of hair: where it is at rest is all that its frames say.
    world.instance_mut(key)?.set_spring_mode(SpringMode::All);
    let [rotation, position] =
        [(1e4, 100.0), (1e6, 1e4)].map(|(stiffness, damping)| Spring { stiffness, damping });
    let (mut times, mut pictures) = (Vec::new(), Vec::new());
    for frame in 0..180 {
        let time = f64::from(frame) / 60.0;
        let (frames, instance) = (player.frames(time), world.instance_mut(key)?);
        match tracked {
            true => instance.track_frames(&frames, rotation, position)?,
            false => instance.follow_frames(&frames)?,
        }
        world.step_blocking(1.0 / 60.0)?;
        times.push(world.timings().step);
        if strip.is_some() && [0, 40, 60, 80, 100, 120].contains(&frame) {
            pictures.push(Panel {
                image: draw(&mut world, key)?,
                caption: format!("{time:.2} s"),
            });
        }
    }
    if let Some(strip) = strip {
        strip.panels = pictures;
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}

/// Draws the body and what hangs on it from behind and the side.
fn draw(world: &mut World, key: InstanceId) -> Result<supple_pictures::Image> {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    world.read_skin_blocking(key, &mut positions, &mut normals)?;
    let avatar = world.instance(key)?.avatar();
    let tissue = avatar.tissue_vertices();
    let hair = tissue + STRANDS * 4 * (OF_STRAND + 1);
    let colour = |v: usize| match v {
        v if v < tissue => from_srgb(0xd8a88a),
        v if v < hair => from_srgb(0x5a3a22),
        _ => from_srgb(0x4a6a9a),
    };
    let colours = (0..positions.len()).map(colour).collect();
    let triangles = avatar.triangles.clone();
    let target = world.instance(key)?.frames()[0].position - DVec3::Y * 0.05;
    let camera = Camera {
        eye: target + 6.0 * DVec3::new(1.0, 0.1, 0.15),
        target,
        up: DVec3::Y,
        projection: Projection::Orthographic(2.0),
    };
    let mut view = View::new(camera, 260, 420);
    view.supersampling = 2;
    view.floor = Some(0.0);
    let surface = Surface {
        positions,
        triangles,
    };
    Ok(render(&[Mesh::coloured(surface, colours)], &view))
}

fn main() -> Result<()> {
    let path = std::env::args().nth(1).unwrap_or("out/hair.png".into());
    let mut strip = Strip::default();
    let (bald, haired) = (Arc::new(avatar(false)?), Arc::new(avatar(true)?));
    for (tracked, how) in [(false, "followed"), (true, "tracked")] {
        let without = run(&bald, tracked, None)?;
        let with = run(&haired, tracked, (!tracked).then_some(&mut strip))?;
        let times = with / without;
        println!(
            "bones {how}: {without:.2} ms a step without spring bones, {with:.2} ms with them, × {times:.2}"
        );
    }
    let path = Path::new(&path);
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(|e| supple::Error::io(folder, e))?;
    }
    strip.compose(from_srgb(0xf4f2ee)).write_png(path)
}
