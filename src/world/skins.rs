//! The posed skins of a world, for who draws them.

use super::backend::Evaluator;
use super::contents::World;
#[cfg(feature = "gpu")]
use super::gpu::SkinBuffer;
use super::keys::InstanceId;
use crate::Result;
use crate::potential::PreviousSkin;
use crate::sim::Members;
use glam::DVec3;

impl World {
    /// The posed skin of an instance as it is now: positions (m, world) and normals, copied out. There is one of each for
    /// each vertex of `avatar().skin`, whose seams are welded: [`RenderMesh::vertices`](crate::model::RenderMesh) of
    /// `avatar().render_meshes` says which of them each vertex of the character's file is.
    ///
    /// # Errors
    /// A key of none; a lost device.
    pub async fn read_skin(
        &mut self,
        instance: InstanceId,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        let (evaluator, place) = self.find_posed(instance).await?;
        evaluator.read_skin(place, positions, normals).await
    }

    /// The positions (m, world) of [`World::read_skin`] at the step before: a renderer draws motion blur and reprojects
    /// by the way between the two. They are the present ones where there is no such way: before an instance's first step,
    /// after `reset`, `teleport_to` and a step longer than [`LONGEST_STEP`](super::LONGEST_STEP), and where its asset has
    /// got more room.
    ///
    /// # Errors
    /// A key of none; a lost device.
    pub async fn read_previous_skin(
        &mut self,
        instance: InstanceId,
        positions: &mut Vec<DVec3>,
    ) -> Result<()> {
        let (evaluator, place) = self.find_posed(instance).await?;
        evaluator.read_previous_skin(place, positions).await
    }

    /// What evaluates an instance and its place there, once the skins are those of the present states.
    async fn find_posed(&mut self, instance: InstanceId) -> Result<(&mut Evaluator, usize)> {
        let (asset, place) = self.find(instance)?;
        if !self.posed {
            self.pose().await?;
        }
        Ok((self.evaluators.get_mut(asset), place))
    }

    /// Poses the skins of the present states.
    async fn pose(&mut self) -> Result<()> {
        self.number()?;
        self.tell_awake()?;
        let characters = self.batches.iter().flat_map(|batch| &batch.characters);
        let instances = characters.map(|c| &c.instance);
        let states: Vec<_> = instances.clone().map(|i| i.state.clone()).collect();
        let offsets = instances.clone().map(|i| i.pose_offsets.as_slice());
        let offsets: Vec<_> = offsets.collect();
        // No step has been made since the last: what has moved by itself has not.
        let previous = instances.map(|instance| match instance.was_put {
            true => PreviousSkin::New,
            false => PreviousSkin::Kept,
        });
        let previous: Vec<_> = previous.collect();
        let posed = self.evaluators.pose_skin(&states, &offsets, &previous);
        posed.await?;
        self.posed = true;
        Ok(())
    }

    /// Where the posed skin of an instance is on the device, to be drawn from by what the host submits after a step; none
    /// where the world is on the CPU. It holds what the last step left: nothing before the first one after the instance's
    /// asset has got more room.
    ///
    /// # Errors
    /// A key of none.
    #[cfg(feature = "gpu")]
    pub fn skin_buffer(&self, instance: InstanceId) -> Result<Option<SkinBuffer<'_>>> {
        let (asset, place) = self.find(instance)?;
        Ok(self.evaluators.get(asset).skin_buffer(place))
    }

    /// Submissions and readbacks since the world's buffers were made, for tests.
    #[cfg(feature = "gpu")]
    #[doc(hidden)]
    pub fn traffic(&self) -> [u64; 2] {
        self.evaluators.traffic()
    }

    /// [`World::read_skin`] on this thread until it is done.
    ///
    /// # Errors
    /// As [`World::read_skin`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_skin_blocking(
        &mut self,
        instance: InstanceId,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        pollster::block_on(self.read_skin(instance, positions, normals))
    }

    /// [`World::read_previous_skin`] on this thread until it is done.
    ///
    /// # Errors
    /// As [`World::read_previous_skin`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_previous_skin_blocking(
        &mut self,
        instance: InstanceId,
        positions: &mut Vec<DVec3>,
    ) -> Result<()> {
        pollster::block_on(self.read_previous_skin(instance, positions))
    }

    /// A box that holds the skin of an instance, for culling: lowest and highest corner, m, in the world. It is made from
    /// the bones and the longest displacement alone, so it is larger than the skin's own.
    ///
    /// # Errors
    /// A key of none.
    pub fn skin_bounds(&self, instance: InstanceId) -> Result<[DVec3; 2]> {
        let (asset, place) = self.find(instance)?;
        let batch = &self.batches[asset];
        let instance = batch.characters[place].instance();
        let parents = &batch.avatar.skeleton.parents;
        Ok(batch.bounds.corners(parents, instance))
    }
}
