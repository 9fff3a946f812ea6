//! The half-space z < 0: d = z, n = e_z.

use super::SignedDistance;
use glam::DVec3;

pub(super) fn signed_distance(point: DVec3) -> SignedDistance {
    SignedDistance {
        distance: point.z,
        normal: DVec3::Z,
    }
}
