//! What contact does to each skin vertex, for who wants more than the sum.

use super::Basis;
use super::asset::Asset;
use super::contact::ContactRow;
use super::evaluate::Instance;
use crate::model::State;
use glam::DVec3;

/// Adds the `rows` of contacts up by skin vertex, of which there is one for each of `areas` (m²): the force on it, N, and
/// the pressure, Pa, which is the normal force by its area. Normal rows are the first `pushes`, friction's the others.
pub(crate) fn sum_by_vertex(
    rows: impl Iterator<Item = ContactRow>,
    pushes: usize,
    areas: &[f64],
    forces: &mut Vec<DVec3>,
    pressures: &mut Vec<f64>,
) {
    forces.clear();
    forces.resize(areas.len(), DVec3::ZERO);
    pressures.clear();
    pressures.resize(areas.len(), 0.0);
    for (k, row) in rows.enumerate() {
        let (v, force) = (row.vertex as usize, -row.force * row.direction);
        forces[v] += force;
        if k < pushes {
            pressures[v] += force.length() / areas[v];
        }
    }
}

impl Instance {
    /// Forces and pressures at `state`, from the step's start.
    pub fn contact_forces<B: Basis>(
        &mut self,
        asset: &Asset<B>,
        state: &State,
        forces: &mut Vec<DVec3>,
        pressures: &mut Vec<f64>,
    ) {
        self.motion.set(&self.step.current, state, self.step.origin);
        self.step.contact(asset, &self.motion, &mut self.touching);
        let pushes = self.list_contacts(asset);
        let areas = &asset.avatar.skin.measure;
        sum_by_vertex(
            self.contacts.iter().copied(),
            pushes,
            areas,
            forces,
            pressures,
        );
    }
}
