// F = I + H, H = Σ_h φ_h ∇U_hᵀ; P(F); C = ∂P/∂F projected to positive semi-definite (method §4).
// Both times the point's stiffness and the state's factor on it. With damping, lagged at the step's start: P += (β/h̃) Cⁿ : (F − F̃), C += (β/h̃) Cⁿ.
// One thread a cubature point.

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> handle_gradients: array<HandleGradient>;
@group(0) @binding(5) var<storage, read> handles: array<Handle>;
@group(0) @binding(6) var<storage, read_write> stress: array<mat3x3<f32>>;
@group(0) @binding(7) var<storage, read_write> tangent: array<Tangent>;
@group(0) @binding(8) var<storage, read> tissue: array<LocalTissue>;
@group(0) @binding(9) var<uniform> material: MaterialParameters;

// φ̃ − φⁿ, m
fn drift(state: BatchState, handle: u32) -> vec3<f32> {
    return handles[state.instance * constants.handles + handle].increment;
}

@compute @workgroup_size(64)
fn elasticity(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= constants.points) {
        return;
    }
    let state = batch[chunk.first + id.y];
    let point = points[i];

    var h = mat3x3<f32>();
    var increment = mat3x3<f32>();
    for (var k = 0u; k < point.handles; k++) {
        let u = handle_gradients[point.first_gradient + k];
        let phi = handles[state.slot * constants.handles + u.handle];
        h += outer(phi.displacement + phi.increment, u.gradient);
        increment += outer(phi.increment - drift(state, u.handle), u.gradient);
    }

    let local = tissue[i];
    let stiffness = stiffness_of(local, state);
    var p = stiffness * pk1_stress(h, local.axes);
    var c = scaled(projected_tangent(h, local.axes), stiffness);
    let damping_rate = damping_rate_of(local, state);
    if (damping_rate > 0.0) {
        let start = tangent[state.instance * constants.points + i];
        p += damping_rate * contract(start, increment);
        c = add_scaled(c, damping_rate, start);
    }
    stress[state.slot * constants.points + i] = p;
    tangent[state.slot * constants.points + i] = c;
}
