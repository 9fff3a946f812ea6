//! An avatar that stands in a world of its own.

use crate::buffers::{Buffers, write};
use crate::error::{OrThrow, Thrown, invalid};
use crate::reading::{Options, Read, read};
use serde::Serialize;
use std::sync::Arc;
use std::task::{Context, Poll, Waker};
use supple::file::{AvatarFile, Parts};
use supple::glam::{DMat3, DQuat, DVec3, Mat4};
use supple::model::{Avatar, Frame, JointBone};
use supple::world::{Backend, Character, ColliderId, InstanceId, World};
use wasm_bindgen::prelude::*;

/// An avatar with all that drives and touches it.
#[wasm_bindgen]
pub struct Core {
    pub(crate) avatar: Arc<Avatar>,
    pub(crate) world: World,
    pub(crate) me: InstanceId,
    pub(crate) colliders: Vec<Option<ColliderId>>,
    buffers: Buffers,
    notes: Vec<String>,
    skin: [Vec<DVec3>; 2],
    pressures: Vec<f64>,
    pub(crate) matrices: Vec<Mat4>,
}

/// What `index.js` is told of an avatar once.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Info<'a> {
    name: &'a str,
    up: supple::model::UpAxis,
    joints: Vec<JointInfo<'a>>,
    /// Joints of each of the file's skins, in its order.
    skins: Vec<&'a [u32]>,
    bones: &'a [String],
    vertices: usize,
    handles: usize,
    cubature_points: usize,
    tissue_mass: f64,
    notes: &'a [String],
}

#[derive(Serialize)]
struct JointInfo<'a> {
    name: &'a str,
    bone: usize,
    /// Whether it is that bone, or rides on it.
    is: bool,
}

/// What was said of the last step.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct StepInfo<'a> {
    stop: supple::sim::Stop,
    iterations: usize,
    contacts: usize,
    contact_force: [f64; 3],
    weight: [f64; 3],
    loads: Vec<LoadInfo<'a>>,
}

#[derive(Serialize)]
struct LoadInfo<'a> {
    bone: &'a str,
    force: [f64; 3],
    torque: [f64; 3],
}

/// The result of what is on the CPU, where nothing is waited for.
pub(crate) fn now<T>(future: impl Future<Output = supple::Result<T>>) -> Thrown<T> {
    let future = std::pin::pin!(future);
    match future.poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => result.or_throw(),
        Poll::Pending => Err(invalid(
            "backend",
            "waits where it must not; this is a fault",
        )),
    }
}

/// A frame of a position (m) and a unit quaternion x, y, z, w; none is no rotation.
pub(crate) fn frame(position: &[f64], rotation: &[f64]) -> Thrown<Frame> {
    let &[x, y, z] = position else {
        let problem = format!("has {} numbers; hand in 3 (m)", position.len());
        return Err(invalid("position", problem));
    };
    let rotation = match *rotation {
        [] => DMat3::IDENTITY,
        [x, y, z, w] => {
            let quaternion = DQuat::from_xyzw(x, y, z, w);
            let length = quaternion.length();
            if !(0.999..=1.001).contains(&length) {
                let problem = format!("has length {length}; hand in a unit quaternion x, y, z, w");
                return Err(invalid("rotation", problem));
            }
            DMat3::from_quat(quaternion.normalize())
        }
        _ => {
            let problem = format!(
                "has {} numbers; hand in a quaternion x, y, z, w",
                rotation.len()
            );
            return Err(invalid("rotation", problem));
        }
    };
    let position = DVec3::new(x, y, z);
    if !position.is_finite() {
        return Err(invalid("position", "is not finite"));
    }
    Ok(Frame { rotation, position })
}

impl Core {
    fn new(avatar: Arc<Avatar>, notes: Vec<String>, up: supple::model::UpAxis) -> Thrown<Self> {
        let mut world = now(World::open(Backend::Cpu))?.with_up(up);
        let asset = world.add_avatar(avatar.clone()).or_throw()?;
        let me = world.add_instance(asset).or_throw()?;
        let mut this = Self {
            buffers: Buffers::new(&avatar),
            avatar,
            world,
            me,
            colliders: Vec::new(),
            notes,
            skin: Default::default(),
            pressures: Vec::new(),
            matrices: Vec::new(),
        };
        this.pose()?;
        Ok(this)
    }

    pub(crate) fn character(&mut self) -> Thrown<&mut Character> {
        self.world.instance_mut(self.me).or_throw()
    }
}

#[wasm_bindgen]
impl Core {
    /// The avatar of a file's bytes, in a world of its own.
    pub fn load(bytes: Vec<u8>, options: &str, progress: &js_sys::Function) -> Thrown<Core> {
        let options = Options::parse(options).or_throw()?;
        let mut tell = |done: usize, of: usize, next: &str| {
            // What a listener throws is its own affair.
            let _ = progress.call3(&JsValue::NULL, &done.into(), &of.into(), &next.into());
        };
        let Read { avatar, notes } = read(bytes, &options, &mut tell).or_throw()?;
        Self::new(Arc::new(avatar), notes, options.world_up)
    }

    /// Another of the same avatar, at rest in a world of its own.
    pub fn again(&self) -> Thrown<Core> {
        Self::new(self.avatar.clone(), self.notes.clone(), self.world.up())
    }

    /// The baked file, with what a step reads.
    pub fn save(&self) -> Thrown<Vec<u8>> {
        AvatarFile::new(Avatar::clone(&self.avatar))
            .to_bytes(Parts::Step)
            .or_throw()
    }

    /// What is to be known of it, as JSON.
    pub fn info(&self) -> String {
        let avatar = &self.avatar;
        let joint = |joint: &'_ supple::model::Joint| (joint.bone.bone(), joint.bone);
        let joints = avatar.joints.joints().iter().map(|j| JointInfo {
            name: &j.name,
            bone: joint(j).0,
            is: matches!(joint(j).1, JointBone::Is(_)),
        });
        let skins = avatar.joints.skins().iter();
        let info = Info {
            name: &avatar.name,
            up: avatar.up,
            joints: joints.collect(),
            skins: skins.map(|skin| &skin.joints[..]).collect(),
            bones: &avatar.skeleton.names,
            vertices: avatar.skin.len(),
            handles: avatar.handles.len(),
            cubature_points: avatar.cubature.len(),
            tissue_mass: avatar.tissue_mass(),
            notes: &self.notes,
        };
        serde_json::to_string(&info).unwrap_or_default()
    }

    /// Triangles of the skin.
    pub fn triangles(&self) -> Vec<u32> {
        self.avatar.triangles.as_flattened().to_vec()
    }

    /// Moves it on by `time_step`, s, and poses the skin.
    pub fn step(&mut self, time_step: f64) -> Thrown<()> {
        now(self.world.step(time_step))?;
        self.pose()
    }

    /// Poses the skin of the present state.
    pub fn pose(&mut self) -> Thrown<()> {
        let [positions, normals] = &mut self.skin;
        now(self.world.read_skin(self.me, positions, normals))?;
        self.buffers.set_skin(&self.avatar, positions, normals);
        Ok(())
    }

    /// Place and length of an array in memory, in numbers.
    pub fn buffer(&self, name: &str) -> Option<Vec<u32>> {
        let array = self.buffers.named(name)?;
        Some(vec![array.as_ptr() as u32, array.len() as u32])
    }

    /// Puts the displacement of the tissue from the skinned shape into its array.
    pub fn find_displacements(&mut self) -> Thrown<()> {
        let displacement = self.world.instance(self.me).or_throw()?.displacement();
        write(&mut self.buffers.displacements, &displacement);
        Ok(())
    }

    /// Puts the forces and pressures of contact into their arrays.
    pub fn find_contacts(&mut self) -> Thrown<()> {
        let forces = &mut self.skin[0];
        now((self.world).read_contacts(self.me, forces, &mut self.pressures))?;
        write(&mut self.buffers.forces, forces);
        for (out, &pressure) in self.buffers.pressures.iter_mut().zip(&self.pressures) {
            *out = pressure as f32;
        }
        Ok(())
    }

    /// Puts the world matrices of the joints as they are simulated into their array.
    pub fn find_joints(&mut self) -> Thrown<()> {
        let matrices = &mut self.matrices;
        (self
            .world
            .instance(self.me)
            .or_throw()?
            .joint_matrices(matrices))
        .or_throw()?;
        self.buffers.set_joints(matrices);
        Ok(())
    }

    /// The sum of the contact forces, N.
    pub fn contact_force(&self) -> Thrown<Vec<f64>> {
        let report = self.world.instance(self.me).or_throw()?.report();
        Ok(report.contact_force.to_array().to_vec())
    }

    /// What the last step said, as JSON.
    pub fn report(&self) -> Thrown<String> {
        let report = self.world.instance(self.me).or_throw()?.report();
        let names = &self.avatar.skeleton.names;
        let info = StepInfo {
            stop: report.stop,
            iterations: report.iterations,
            contacts: report.contacts,
            contact_force: report.contact_force.to_array(),
            weight: report.weight.to_array(),
            loads: (report.loads.iter())
                .map(|load| LoadInfo {
                    bone: &names[load.bone],
                    force: load.force.to_array(),
                    torque: load.torque.to_array(),
                })
                .collect(),
        };
        Ok(serde_json::to_string(&info).unwrap_or_default())
    }
}
