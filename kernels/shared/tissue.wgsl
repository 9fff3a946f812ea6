// What the material has of its own at a cubature point, and what an instance's factors make of it.

struct LocalTissue {
    axes: mat3x3<f32>,   // G: its axes (normal to the skin, along the bone, around it) as columns
    stiffness: f32,      // factor on the energy
    damping_time: f32,   // β, s
    muscle: f32,         // its share, 0 to 1
}

// How many times as stiff tension makes tissue that is partly muscle: 1 + (T − 1) τ m
fn tensed(local: LocalTissue, state: BatchState) -> f32 {
    return 1.0 + state.tension * local.muscle;
}

// The factor on the energy.
fn stiffness_of(local: LocalTissue, state: BatchState) -> f32 {
    return state.stiffness * local.stiffness * tensed(local, state);
}

// β/h: ω goes with the root of the stiffness, so that ζ = ω β/2 stays under tension. 0 where nothing damps.
fn damping_rate_of(local: LocalTissue, state: BatchState) -> f32 {
    return state.damping_rate * local.damping_time / sqrt(tensed(local, state));
}
