//! A scene's motion as targets of bones.

use crate::motion::{Playback, RootTracking, TrackedMotion};
use supple::Result;
use supple::internal::math::rotation_log;
use supple::model::{Frame, Skeleton};
use supple::sim::{Instance, Pin};
use supple::skeleton::Tracking;
use supple_files::{BoneMap, blend};

/// Draws the bones that a motion drives to where it has them.
pub(super) struct MotionDriver {
    playback: Playback,
    skeleton: Skeleton,
    options: TrackedMotion,
    /// Bones with targets, rising.
    bones: Vec<usize>,
    /// The one of them whose place follows too.
    root: Option<usize>,
    /// Where the motion is a step after its start, if it begins at once.
    next: Option<Vec<Frame>>,
}

impl MotionDriver {
    /// Drives all mapped bones but those for which `own` holds: the scene drives them itself. `start` is
    /// where the avatar stands; with nothing to ease in it becomes the motion's first pose, and bones begin as fast as a
    /// clip has them move in its first `time_step`, s.
    pub fn new(
        options: &TrackedMotion,
        mut playback: Playback,
        skeleton: &Skeleton,
        start: &mut Vec<Frame>,
        time_step: f64,
        own: impl Fn(usize) -> bool,
    ) -> Result<Self> {
        playback.stand_at(start);
        let root = playback.retarget().root();
        let bones = playback.retarget().driven().filter(|&b| !own(b)).collect();
        let mut next = None;
        if options.ease_in == 0.0 {
            *start = playback.frames(0.0)?;
            if let Playback::Clip(_) = playback {
                next = Some(playback.frames(time_step)?);
            }
        }
        Ok(Self {
            playback,
            skeleton: skeleton.clone(),
            options: options.clone(),
            root: root.filter(|&b| !own(b)),
            bones,
            next,
        })
    }

    pub fn bone_map(&self) -> &BoneMap {
        self.playback.retarget().map()
    }

    pub fn notes(&self) -> &[String] {
        self.playback.notes()
    }

    /// Whether `bone` is the root and follows exactly.
    fn pinned(&self, bone: usize) -> bool {
        self.options.root == RootTracking::Pin && self.root == Some(bone)
    }

    /// Lets bones move on from `start` as the motion does.
    pub fn launch(&self, start: &[Frame], time_step: f64, instance: &mut Instance) {
        for (bone, next) in self.next.iter().flatten().enumerate() {
            let (now, at) = (start[bone], instance.state.frames[bone]);
            let velocity = (next.position - now.position) / time_step;
            let turn = rotation_log(next.rotation * now.rotation.transpose());
            instance.set_motion(bone, at, velocity, turn / time_step);
        }
    }

    /// Adds targets, and a pin, at `start`.
    pub fn start(&self, start: &[Frame], instance: &mut Instance) {
        for &bone in &self.bones {
            let frame = start[bone];
            if self.pinned(bone) {
                instance.pins.push(Pin { bone, frame });
                continue;
            }
            let placed = self.root == Some(bone) && self.options.root != RootTracking::Free;
            instance.targets.push(Tracking {
                rotation: Some(self.options.rotation),
                position: placed.then_some(self.options.position),
                ..Tracking::new(bone, frame)
            });
        }
    }

    /// Moves the targets, which come after the scene's own `pins` and `targets`, to `time`. During ease-in
    /// they are between the start and the motion, part u² (3 − 2u) of the way: no leap, nor one of velocity.
    pub fn drive(
        &mut self,
        time: f64,
        start: &[Frame],
        pins: usize,
        targets: usize,
        instance: &mut Instance,
    ) -> Result<()> {
        let mut frames = self.playback.frames(time)?;
        if time < self.options.ease_in {
            let u = time / self.options.ease_in;
            let own = &start[..self.skeleton.len()];
            frames = blend(&self.skeleton, own, &frames, u * u * (3.0 - 2.0 * u));
        }
        if let (Some(root), RootTracking::Hold) = (self.root, self.options.root) {
            frames[root].position = start[root].position;
        }
        for pin in instance.pins.iter_mut().skip(pins) {
            pin.frame = frames[pin.bone];
        }
        for target in instance.targets.iter_mut().skip(targets) {
            target.frame = frames[target.bone];
        }
        Ok(())
    }
}
