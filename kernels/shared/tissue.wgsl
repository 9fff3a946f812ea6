// What the material has of its own at a cubature point.

struct LocalTissue {
    axes: mat3x3<f32>,   // G: its axes (normal to the skin, along the bone, around it) as columns
    stiffness: f32,      // factor on the energy
    damping_time: f32,   // β, s
    muscle: f32,         // its share, 0 to 1
}
