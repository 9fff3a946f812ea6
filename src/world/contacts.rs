//! What presses where on the skins of a world.

use super::contents::World;
use super::keys::InstanceId;
use crate::Result;
use glam::DVec3;

impl World {
    /// What touches an instance, vertex by vertex of `avatar().skin`, in the state that the last step ended with: the force
    /// of contact and friction on it (N, world axes), and the pressure (Pa: the normal force by the vertex's area in the
    /// reference shape). The forces add up to [`InstanceReport::contact_force`](crate::sim::InstanceReport) where that is
    /// the end's. All are 0 where the instance took no part in a step, or was put elsewhere since, as for
    /// [`World::read_previous_skin`].
    ///
    /// The contacts are listed again when this is asked: on the CPU in f64; on the device by the step's own kernels, which
    /// costs a submission and a readback, and leaves out what the step left out.
    ///
    /// # Errors
    /// A key of none; a lost device.
    pub async fn read_contacts(
        &mut self,
        instance: InstanceId,
        forces: &mut Vec<DVec3>,
        pressures: &mut Vec<f64>,
    ) -> Result<()> {
        let (asset, place) = self.find(instance)?;
        let batch = &self.batches[asset];
        let instance = &batch.characters[place].instance;
        if instance.was_put || !instance.active {
            let vertices = batch.avatar.skin.len();
            forces.clear();
            forces.resize(vertices, DVec3::ZERO);
            pressures.clear();
            pressures.resize(vertices, 0.0);
            return Ok(());
        }
        let evaluator = self.evaluators.get_mut(asset);
        evaluator
            .read_contacts(place, &instance.state, forces, pressures)
            .await
    }

    /// [`World::read_contacts`] on this thread until it is done.
    ///
    /// # Errors
    /// As [`World::read_contacts`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_contacts_blocking(
        &mut self,
        instance: InstanceId,
        forces: &mut Vec<DVec3>,
        pressures: &mut Vec<f64>,
    ) -> Result<()> {
        pollster::block_on(self.read_contacts(instance, forces, pressures))
    }
}
