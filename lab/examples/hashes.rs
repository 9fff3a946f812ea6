//! Hashes of what must not change while code is moved: states of every committed scene after 200 steps on the CPU, and
//! every part of every baked avatar.
//!
//! `cargo run --release -p supple-lab --example hashes > table` prints them; another commit's table on the same machine
//! is compared with `diff`. Other processors may round otherwise, so that no table of one machine binds another.
//! `lab/hashes.txt` is that of an AMD EPYC by Rust 1.95, after worlds, closed joints and bakes of bodies with like halves. Its
//! first version, of a Xeon with AVX-512 at commit 5326906, was held while the engine was cut out of one crate.

use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use supple::internal::math::Rows;
use supple::model::{Avatar, Frame, PointSet, State};
use supple::potential::CpuPotential;
use supple::sim::{Instance, Pin, Simulation};
use supple::skeleton::Tracking;
use supple_bake::bake;
use supple_samples::Sample;
use supple_scene::{AvatarSource, Driver, Scene, avatar_source_of, read_scene};

const STEPS: usize = 200;

/// Who drives the bones.
const MODES: [&str; 4] = ["committed", "free", "targets", "pins"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenes = Path::new("assets/scenes");
    let mut names: Vec<PathBuf> = std::fs::read_dir(scenes)?
        .map(|e| e.map(|e| e.path()))
        .collect::<Result<_, _>>()?;
    names.retain(|p| p.extension().is_some_and(|e| e == "toml"));
    names.sort();
    let mut baked: Vec<(AvatarSource, Arc<Avatar>)> = Vec::new();
    for sample in [
        Sample::Body,
        Sample::Hand,
        Sample::Finger,
        Sample::LimbS,
        Sample::LimbM,
    ] {
        let source = AvatarSource::of_sample(sample);
        let avatar = bake_of(&format!("{sample:?}"), &source)?;
        baked.push((source, avatar));
    }
    let assets = Path::new("../shared/assets");
    for file in [
        "webxr-generic-hand-left.glb",
        "khronos-CesiumMan.glb",
        "khronos-RiggedSimple.glb",
        "makehuman-female-cmu-02_01.glb",
        "makehuman-female-game_engine-smpl-layout.npz",
    ] {
        let path = assets.join(file);
        if path.exists() {
            bake_of(file, &avatar_source_of(&path)?)?;
        }
    }
    for path in names {
        let scene = read_scene(&path)?;
        let found = baked.iter().find(|(source, _)| *source == scene.avatar);
        let avatar = match found {
            Some((_, avatar)) => avatar.clone(),
            None => {
                let avatar = bake_of(&scene.name, &scene.avatar)?;
                baked.push((scene.avatar.clone(), avatar.clone()));
                avatar
            }
        };
        for mode in MODES {
            println!(
                "{:<20} {mode:<10} {}",
                scene.name,
                play(&scene, &avatar, mode)?
            );
        }
    }
    Ok(())
}

fn play(scene: &Scene, avatar: &Arc<Avatar>, mode: &str) -> supple::Result<String> {
    let mut avatar = avatar.clone();
    scene.dress(Arc::make_mut(&mut avatar))?;
    let avatar = &avatar;
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = Simulation::new(avatar, potential, scene.settings)?;
    let mut driver = Driver::new(scene, avatar)?;
    driver.start(avatar, &mut simulation.instances_mut()[0]);
    let start = simulation.instances()[0].state.clone();
    let own = |instance: &mut Instance| match mode {
        "committed" => {}
        "free" => {
            instance.pins.clear();
            instance.targets.clear();
        }
        "targets" => {
            instance.pins.clear();
            instance.targets = frames(avatar, &start)
                .map(|(b, f)| Tracking::new(b, f))
                .collect();
        }
        _ => {
            instance.targets.clear();
            instance.pins = frames(avatar, &start)
                .map(|(bone, frame)| Pin { bone, frame })
                .collect();
        }
    };
    let mut force = Hash::new();
    for step in 1..=STEPS {
        let time = step as f64 * scene.settings.time_step;
        let instance = &mut simulation.instances_mut()[0];
        if mode == "committed" {
            driver.drive(time, instance)?;
        } else {
            for (collider, frame) in instance
                .colliders
                .iter_mut()
                .skip(avatar.bodies.len())
                .zip(driver.collider_frames(time))
            {
                collider.frame = frame;
            }
            own(instance);
        }
        match simulation.step_blocking() {
            Ok(report) => force.vector(report.instances[0].contact_force),
            Err(error) => return Ok(format!("step {step}: {error}")),
        }
    }
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    simulation.read_skin_blocking(0, &mut skin, &mut normals)?;
    let mut state = Hash::new();
    state.state(&simulation.instances()[0].state);
    let mut drawn = Hash::new();
    skin.iter().chain(&normals).for_each(|v| drawn.vector(*v));
    Ok(format!("state {state} skin {drawn} forces {force}"))
}

fn frames<'a>(avatar: &Avatar, state: &'a State) -> impl Iterator<Item = (usize, Frame)> + 'a {
    state.frames[..avatar.bones()].iter().copied().enumerate()
}

fn bake_of(name: &str, source: &AvatarSource) -> supple::Result<Arc<Avatar>> {
    let (body, recipe) = source.body()?;
    let (avatar, _) = bake(&body, &recipe, &mut |_| {})?;
    let part = |what: &str, add: &dyn Fn(&mut Hash)| {
        let mut hash = Hash::new();
        add(&mut hash);
        println!("bake {name:<44} {what:<14} {hash}");
    };
    part("skeleton", &|h| {
        h.add(format!("{:?}", avatar.skeleton.names).as_bytes());
        h.add(
            format!(
                "{:?} {:?}",
                avatar.skeleton.parents, avatar.skeleton.aliases
            )
            .as_bytes(),
        );
        h.encoded(&avatar.skeleton.limits);
        avatar.skeleton.joints.iter().for_each(|j| h.vector(*j));
        (avatar
            .bone_masses
            .iter()
            .flat_map(|m| m.second_moment)
            .flatten())
        .for_each(|s| h.number(s));
    });
    part("handles", &|h| {
        avatar.handles.iter().for_each(|p| h.vector(*p))
    });
    part("cubature", &|h| h.points(&avatar.cubature));
    part("skin", &|h| h.points(&avatar.skin));
    part("drawing", &|h| {
        avatar
            .triangles
            .iter()
            .flatten()
            .for_each(|v| h.add(&v.to_le_bytes()));
        h.shares(&avatar.attached);
        h.encoded(&avatar.render_meshes);
    });
    part("tissue", &|h| {
        h.encoded(&avatar.material);
        h.encoded(&avatar.tissue);
        h.number(avatar.density);
        h.add(&[u8::from(avatar.captured_under_gravity)]);
    });
    part("layer", &|h| {
        let layer = &avatar.layer;
        layer.mesh.nodes.iter().for_each(|n| h.vector(*n));
        layer
            .mesh
            .tets
            .iter()
            .flatten()
            .for_each(|n| h.add(&n.to_le_bytes()));
        layer.tissue_fraction.iter().for_each(|f| h.number(*f));
        h.add(format!("{:?}", layer.bone_of_node).as_bytes());
        for row in layer.skinning.iter() {
            row.iter().for_each(|w| h.share((w.bone, w.weight)));
        }
        h.shares(&layer.basis);
        h.shares(&layer.skin_embedding);
        h.encoded(&layer.tissue);
    });
    Ok(Arc::new(avatar))
}

/// FNV-1a, 64 bits, of numbers' bits in an order that does not hang on how they are stored.
struct Hash(u64);

impl Hash {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    /// A value as postcard has it: without names.
    fn encoded(&mut self, value: &impl serde::Serialize) {
        self.add(&postcard::to_allocvec(value).expect("plain data"));
    }

    fn number(&mut self, number: f64) {
        self.add(&number.to_bits().to_le_bytes());
    }

    fn vector(&mut self, vector: DVec3) {
        vector.to_array().into_iter().for_each(|x| self.number(x));
    }

    fn share(&mut self, (index, share): (u32, f64)) {
        self.add(&index.to_le_bytes());
        self.number(share);
    }

    fn shares(&mut self, rows: &Rows<(u32, f64)>) {
        for row in rows.iter() {
            self.add(&(row.len() as u32).to_le_bytes());
            row.iter().for_each(|s| self.share(*s));
        }
    }

    fn state(&mut self, state: &State) {
        for frame in &state.frames {
            frame
                .rotation
                .to_cols_array()
                .into_iter()
                .for_each(|x| self.number(x));
            self.vector(frame.position);
        }
        state.handles.iter().for_each(|h| self.vector(*h));
    }

    fn points(&mut self, points: &PointSet) {
        points.position.iter().for_each(|p| self.vector(*p));
        points.measure.iter().for_each(|m| self.number(*m));
        for row in points.skinning.iter() {
            self.add(&(row.len() as u32).to_le_bytes());
            row.iter().for_each(|w| self.share((w.bone, w.weight)));
        }
        for row in points.basis.iter() {
            self.add(&(row.len() as u32).to_le_bytes());
            for u in row {
                self.share((u.handle, u.value));
                self.vector(u.gradient);
            }
        }
        // A value that is 0 is one whether it is stored or not.
        let blend = &points.pose_blend;
        for k in 0..blend.features {
            for i in 0..points.len() {
                let column = blend.columns[k * points.len() + i];
                if column != [0.0; 3] {
                    self.add(&((k * points.len() + i) as u64).to_le_bytes());
                    column
                        .iter()
                        .for_each(|x| self.add(&x.to_bits().to_le_bytes()));
                }
            }
        }
    }
}

impl std::fmt::Display for Hash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}
