//! Where a body is soft: belly, breast, buttocks, thighs, calves, upper arms and cheeks.

use super::anatomy;
use glam::DVec3;
use supple::model::Surface;

/// An ellipsoid around a soft part: centre and radii, mm.
const PARTS: [([f64; 3], [f64; 3]); 7] = [
    // Belly and flanks.
    ([0.0, 1025.0, 60.0], [150.0, 115.0, 110.0]),
    // Breast.
    ([82.0, 1275.0, 85.0], [72.0, 66.0, 70.0]),
    // Buttock and hip.
    ([95.0, 872.0, -70.0], [100.0, 105.0, 110.0]),
    // Thigh.
    ([94.0, 690.0, -6.0], [120.0, 150.0, 120.0]),
    // Calf.
    ([93.0, 345.0, -45.0], [75.0, 95.0, 50.0]),
    // Cheek.
    ([42.0, 1565.0, 62.0], [28.0, 28.0, 34.0]),
    // Under the chin.
    ([0.0, 1490.0, 52.0], [24.0, 14.0, 24.0]),
];

/// Upper arm: from, to along the arm.
const UPPER_ARM: [f64; 2] = [70.0, 225.0];

/// Whether each vertex lies on a soft part.
pub(super) fn soft(skin: &Surface) -> Vec<bool> {
    let is_soft = |p: &DVec3| {
        let p = DVec3::new(p.x.abs(), p.y, p.z);
        let station = anatomy::arm().local(p).x;
        let on_arm = p.y > 1300.0 && (UPPER_ARM[0]..UPPER_ARM[1]).contains(&station);
        on_arm
            || PARTS.iter().any(|&(centre, radii)| {
                ((p - DVec3::from_array(centre)) / DVec3::from_array(radii)).length_squared() < 1.0
            })
    };
    skin.positions.iter().map(is_soft).collect()
}
