//! A seeded random scene run on the device, and everything its kernels read and wrote.

use super::bound::abs;
use super::input::{avatar, colliders, reach, rounded_collider};
use super::{INSTANCE, INSTANCES, STATES};
use bytemuck::AnyBitPattern;
use std::collections::HashMap;
use std::sync::Arc;
use supple::Result;
use supple::collider::Collider;
use supple::glam::{DMat3, DVec3};
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::internal::cpu::displacement::FrameMotion;
use supple::internal::cpu::inertial_target::PastMotion;
use supple::internal::gpu::{Sources, shared};
use supple::internal::math::Random;
use supple::internal::{pose_offsets, random_state};
use supple::material::MaterialPoint;
use supple::model::{Avatar, Frame, InertialTarget, PointSet, State};
use supple::potential::{
    BlockPattern, Difference, Evaluation, GpuKernels, GpuOptions, GpuPotential, Potential,
    StepStart, TissueFactors, Trial,
};

/// h: a power of two, so that its inverse is exact.
pub const TIME_STEP: f64 = 1.0 / 128.0;
/// h̃, s.
pub const INERTIAL_STEP: f64 = 0.6875 * TIME_STEP;
/// With its factor.
pub const GRAVITY: DVec3 = DVec3::new(1.5, -2.25, 9.75);
/// So that of the slips some are below it and some above.
pub const SLIP_SPEED: f64 = 0.125;
pub const OPTIONS_COLLIDERS: usize = 6;
pub const OPTIONS_CONTACTS: usize = 600;

/// When the buffers were looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Phase {
    /// After evaluate.
    Evaluated,
    /// After energy_differences.
    Compared,
    /// After pose_skin.
    Posed,
}

const LOOKED_AT: &[(Phase, &[&str])] = &[
    (
        Phase::Evaluated,
        &[
            "pose_features",
            "frames",
            "handles",
            "past_frames",
            "past_handles",
            "unposed",
            "skin_unposed",
            "motion",
            "stress",
            "tangent",
            "distances",
            "colliders",
            "previous_colliders",
            "lagged_distances",
            "lagged",
            "slips",
            "contacts",
            "block_contacts",
            "contact_rows",
            "point_gradients",
            "point_hessians",
            "summaries",
        ],
    ),
    (
        Phase::Compared,
        &[
            "frames",
            "handles",
            "motion",
            "tangent",
            "distances",
            "slips",
            "summaries",
        ],
    ),
    (
        Phase::Posed,
        &[
            "pose_features",
            "frames",
            "handles",
            "posed_skin_unposed",
            "skin_vertices",
        ],
    ),
];

/// What happened.
pub struct Scene {
    pub avatar: Arc<Avatar>,
    pub pattern: BlockPattern,
    /// Relative to the instance's origin, rounded and with the factor on friction, as the kernels got them.
    pub colliders: Vec<Collider>,
    pub evaluation: Evaluation,
    /// Of every instance; skins are posed with those of another than the step is.
    offsets: Vec<Vec<[f32; 3]>>,
    buffers: HashMap<(Phase, &'static str), Vec<u8>>,
}

/// Of all instances, none of them 1.
pub fn factors() -> TissueFactors {
    let mut factors = TissueFactors::default();
    (factors.stiffness, factors.damping) = (1.25, 0.75);
    (factors.gravity, factors.friction) = (2.0, 0.5);
    factors.tension = 0.25;
    factors
}

/// Two frames of the instance that is looked at, and others of the others.
pub fn prescribed(avatar: &Avatar, instance: usize) -> Vec<bool> {
    let frames = 0..avatar.skeleton.len();
    frames.map(|frame| frame % 3 == instance).collect()
}

/// The software or hardware adapter of this machine.
pub fn device() -> GpuDevice {
    pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware)).expect(
        "GPU tests need an adapter and never skip: install a Vulkan driver, \
         for example the package mesa-vulkan-drivers",
    )
}

/// As after two steps of unlike lengths.
pub fn inertia(past: &[State]) -> InertialTarget<'_> {
    InertialTarget {
        past,
        weights: WEIGHTS,
        drift: 0.3,
        step: INERTIAL_STEP,
        share: None,
    }
}

/// c₁ to c₃.
const WEIGHTS: [f64; 3] = [-2.4, 0.9, -0.15];

impl Scene {
    /// Runs the kernels of `sources` (the library's own if `None`).
    pub fn run(gpu: &GpuDevice, seed: u64, sources: Option<Sources>) -> Result<Self> {
        let avatar = Arc::new(avatar(seed));
        let random = &mut Random::new(seed);
        let options = GpuOptions {
            colliders: OPTIONS_COLLIDERS,
            contacts: OPTIONS_CONTACTS,
            trials: STATES / 2,
            ..GpuOptions::default()
        };
        let (device, queue) = (&gpu.device, &gpu.queue);
        let sources = sources.unwrap_or_else(|| Sources::new(&avatar.material));
        let kernels = pollster::block_on(GpuKernels::compile_sources(device, &sources, None))?;
        let mut potential = GpuPotential::with_kernels(
            device,
            queue,
            &kernels,
            avatar.clone(),
            INSTANCES,
            options,
        )?;
        let dofs = avatar.space().dofs();
        let first_handle = 6 * avatar.skeleton.len();
        let step = |random: &mut Random, size: f64| -> Vec<f64> {
            let size = |dof| if dof < first_handle { size } else { 5.0 * size };
            (0..dofs)
                .map(|dof| random.uniform(-size(dof), size(dof)))
                .collect()
        };
        // Handles far out: stretched, squeezed and inverted points, so that every negative eigenvalue occurs.
        let mut earliest: Vec<State> = (0..INSTANCES)
            .map(|i| random_state(seed + i as u64, &avatar, 0.4, 2e-3))
            .collect();
        for state in &mut earliest {
            state.handles.iter_mut().for_each(|phi| *phi *= reach(seed));
        }
        let mut moved = |states: &[State], size: f64| -> Vec<State> {
            let steps = states.iter().map(|s| s.moved(&step(random, size), 1.0));
            steps.collect()
        };
        let earlier = moved(&earliest, 1e-3);
        let previous = moved(&earlier, 1e-3);
        let current = moved(&previous, 1e-3);
        let state = moved(&current, 1e-3);
        let trial = moved(&state, 5e-4);
        let colliders: Vec<Vec<Collider>> = (current.iter().enumerate())
            .map(|(i, q)| colliders(seed + i as u64, q.frames[0].position))
            .collect();
        let prescribed: Vec<_> = (0..INSTANCES).map(|i| prescribed(&avatar, i)).collect();
        let offsets: Vec<_> = (0..INSTANCES)
            .map(|i| pose_offsets(seed + i as u64, &avatar, 5e-3))
            .collect();
        let past: Vec<[State; 3]> = (0..INSTANCES)
            .map(|i| [&previous, &earlier, &earliest].map(|states| states[i].clone()))
            .collect();
        let starts: Vec<_> = (0..INSTANCES)
            .map(|i| StepStart {
                time_step: TIME_STEP,
                inertia: inertia(&past[i]),
                current: &current[i],
                colliders: &colliders[i],
                tissue_gravity: GRAVITY / factors().gravity,
                slip_speed: SLIP_SPEED,
                geometric_contact: false,
                factors: factors(),
                pose_offsets: &offsets[i],
                prescribed: &prescribed[i],
            })
            .collect();

        let mut scene = Self {
            pattern: potential.pattern().clone(),
            colliders: Vec::new(),
            evaluation: Evaluation::default(),
            offsets: offsets.clone(),
            buffers: HashMap::new(),
            avatar,
        };
        pollster::block_on(async {
            let active = [true; INSTANCES];
            let mut out = vec![Evaluation::default(); INSTANCES];
            potential.begin_step(&starts, &active).await?;
            potential.evaluate(&state, &active, &mut out).await?;
            scene.evaluation = out.swap_remove(INSTANCE);
            scene.look(&mut potential, Phase::Evaluated).await?;
            let compared = Trial {
                instance: INSTANCE,
                base: &state[INSTANCE],
                state: &trial[INSTANCE],
            };
            potential
                .energy_differences(&[compared], &mut [Difference::default()])
                .await?;
            scene.look(&mut potential, Phase::Compared).await?;
            let others = [&scene.offsets[1][..], &scene.offsets[0][..]];
            potential.pose_skin(&state, &others, &[]).await?;
            scene.look(&mut potential, Phase::Posed).await
        })?;
        let origin = current[INSTANCE].frames[0].position;
        scene.colliders = colliders[INSTANCE]
            .iter()
            .map(|c| rounded_collider(c.relative_to(origin)))
            .collect();
        for collider in &mut scene.colliders {
            collider.friction *= factors().friction;
        }
        Ok(scene)
    }

    async fn look(&mut self, potential: &mut GpuPotential, phase: Phase) -> Result<()> {
        for (at, names) in LOOKED_AT {
            if *at == phase {
                for name in *names {
                    let bytes = potential.intermediate(name).await?;
                    self.buffers.insert((phase, name), bytes);
                }
            }
        }
        Ok(())
    }

    /// k a of skin vertex `v` and collider `c`, N/m.
    pub fn contact_stiffness(&self, v: usize, c: usize) -> f64 {
        let of_tissue = self.avatar.contact_stiffness[v] * factors().stiffness;
        let k = self.colliders[c].stiffness.unwrap_or(of_tissue.min(1e8));
        k * self.avatar.skin.measure[v]
    }

    /// The tissue at cubature point `i`, with its factors.
    pub fn tissue_at(&self, i: usize) -> MaterialPoint<'_> {
        let mut tissue = self.avatar.tissue_at(i);
        let (local, factors) = (&mut tissue.local, factors());
        // (T − 1) τ
        let tense = 1.0 + 7.0 * factors.tension * local.muscle;
        local.stiffness *= factors.stiffness * tense;
        local.damping_time /= tense.sqrt();
        tissue
    }

    /// β/h̃ of cubature point `i`, with its factor.
    pub fn damping_rate(&self, i: usize) -> f64 {
        factors().damping / INERTIAL_STEP * self.tissue_at(i).local.damping_time
    }

    /// Items `[index · count, (index + 1) · count)` of a buffer.
    pub fn items<T: AnyBitPattern>(
        &self,
        phase: Phase,
        name: &'static str,
        index: usize,
        count: usize,
    ) -> Vec<T> {
        let size = size_of::<T>();
        self.buffers[&(phase, name)][index * count * size..(index + 1) * count * size]
            .chunks_exact(size)
            .map(bytemuck::pod_read_unaligned)
            .collect()
    }

    /// The looked-at instance's posed skin, up to the next one's: each begins at a multiple of 256 bytes.
    pub fn skin_vertices(&self) -> Vec<shared::SkinVertex> {
        let stride = self.avatar.skin.len().next_multiple_of(8);
        self.items(Phase::Posed, "skin_vertices", INSTANCE, stride)
    }

    /// The looked-at instance's pose features, `count` of them. In a batch the starts of a step come behind its states, and
    /// what is posed behind the starts.
    pub fn pose_features(&self, phase: Phase, count: usize) -> Vec<f32> {
        let index = match phase {
            Phase::Evaluated => STATES + INSTANCE,
            Phase::Compared => INSTANCE,
            Phase::Posed => STATES + INSTANCES + INSTANCE,
        };
        self.items(phase, "pose_features", index, count)
    }

    /// Frames of the state in `slot`.
    pub fn frames(&self, phase: Phase, slot: usize) -> Vec<Frame> {
        let frames: Vec<shared::Frame> =
            self.items(phase, "frames", slot, self.avatar.skeleton.len());
        let frame = |f: &shared::Frame| Frame {
            rotation: mat(f.rotation),
            position: vec(f.position),
        };
        frames.iter().map(frame).collect()
    }

    /// Their increments.
    pub fn motions(&self, phase: Phase, slot: usize) -> Vec<FrameMotion> {
        let frames: Vec<shared::Frame> =
            self.items(phase, "frames", slot, self.avatar.skeleton.len());
        let motion = |f: &shared::Frame| FrameMotion {
            rotation: mat(f.rotation),
            rotation_change: mat(f.rotation_increment),
            translation_change: vec(f.position_increment),
        };
        frames.iter().map(motion).collect()
    }

    /// What inertia takes from the past, and the same with nothing but sizes in it.
    pub fn past(&self, phase: Phase) -> [PastMotion; 2] {
        let space = self.avatar.space();
        let frames: Vec<shared::PastFrame> =
            self.items(phase, "past_frames", INSTANCE, space.frames);
        let handles: Vec<shared::PastHandle> =
            self.items(phase, "past_handles", INSTANCE, space.handles);
        let rotations = |of: fn(&shared::PastFrame) -> shared::Mat3| -> Vec<DMat3> {
            frames.iter().map(|f| mat(of(f))).collect()
        };
        let changes = |of: fn(&shared::PastHandle) -> [f32; 3]| -> Vec<DVec3> {
            handles.iter().map(|h| vec(of(h))).collect()
        };
        let past = PastMotion {
            frames: (frames.iter())
                .map(|f| (mat(f.turn), vec(f.shift)))
                .collect(),
            rotations: [
                rotations(|f| f.first),
                rotations(|f| f.second),
                rotations(|f| f.third),
            ],
            handles: [
                changes(|h| h.first),
                changes(|h| h.second),
                changes(|h| h.third),
            ],
            terms: 3,
        };
        let mut sizes = past.clone();
        for (turn, shift) in &mut sizes.frames {
            (*turn, *shift) = (abs(*turn), shift.abs());
        }
        (sizes.rotations.iter_mut().flatten()).for_each(|r| *r = abs(*r));
        (sizes.handles.iter_mut().flatten()).for_each(|h| *h = h.abs());
        [past, sizes]
    }

    /// (φ_base, Δφ) of the state in `slot`.
    pub fn handles(&self, phase: Phase, slot: usize) -> (Vec<DVec3>, Vec<DVec3>) {
        let handles: Vec<shared::Handle> =
            self.items(phase, "handles", slot, self.avatar.handles.len());
        handles
            .iter()
            .map(|h| (vec(h.displacement), vec(h.increment)))
            .unzip()
    }

    /// φ of the state in `slot`.
    pub fn displaced(&self, phase: Phase, slot: usize) -> Vec<DVec3> {
        let (base, increment) = self.handles(phase, slot);
        base.iter().zip(&increment).map(|(b, i)| *b + *i).collect()
    }

    /// x̄ of the looked-at instance's `set`.
    pub fn rest(&self, phase: Phase, name: &'static str, set: &PointSet) -> Vec<DVec3> {
        let rest: Vec<[f32; 4]> = self.items(phase, name, INSTANCE, set.len());
        rest.iter().map(|r| vec([r[0], r[1], r[2]])).collect()
    }

    /// The looked-at instance's offsets of the skin.
    pub fn offsets(&self, phase: Phase) -> &[[f32; 3]] {
        match phase {
            Phase::Evaluated | Phase::Compared => &self.offsets[INSTANCE],
            Phase::Posed => &self.offsets[1 - INSTANCE],
        }
    }

    /// What cubature points did in `slot`.
    pub fn moved(&self, phase: Phase, slot: usize) -> Vec<shared::Motion> {
        self.items(phase, "motion", slot, self.avatar.cubature.len())
    }

    /// J of all bones.
    pub fn joints(&self) -> &[DVec3] {
        &self.avatar.skeleton.joints
    }
}

pub fn vec(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

pub fn mat(m: shared::Mat3) -> DMat3 {
    let [x, y, z] = m.map(|c| vec([c[0], c[1], c[2]]));
    DMat3::from_cols(x, y, z)
}
