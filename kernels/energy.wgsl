// E(state) − E(base) of each term from increments, summed in a fixed tree. With δ = x − x_base and
// e = d_base − ŷ the base's own distance from the inertial target:
//   inertia  m/(2h̃²) (|δ + e|² − |e|²) = m/(2h̃²) δ·(δ + 2e)      gravity  −m g·δ
//   elastic  w (Ψ(F) − Ψ(F_base))    damping  w β/(2h̃) (D : Cⁿ : D − B : Cⁿ : B) with D = B + ΔF and
//   B = F_base − F̃    contact  ½ k a (δ₊² − δ_base₊²), δ = d̂ − d
//   friction  μ λ (f₀(|u_T|) − f₀(|u_T,base|))

struct PartialEnergy {
    inertia: f32,
    gravity: f32,
    elastic: f32,
    damping: f32,
    force: vec3<f32>,  // of the contacts on the skin, N
    contact: f32,
    friction: f32,
    left_out: f32,     // contacts for which there was no room
    unforeseen: f32,   // of contacts, what a quadratic model at the base does not foresee, N
    pressing: f32,     // Σ k a δ, N
}

struct Summary {
    energy: PartialEnergy,
    contacts: u32,
    lagged: u32,
}

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> batch: array<BatchState>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> handle_gradients: array<HandleGradient>;
@group(0) @binding(5) var<storage, read> handles: array<Handle>;
@group(0) @binding(6) var<storage, read> motion: array<Motion>;
@group(0) @binding(7) var<storage, read> tangent: array<Tangent>;
@group(0) @binding(8) var<storage, read> colliders: array<Collider>;
@group(0) @binding(9) var<storage, read> distances: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read> contacts: array<Contact>;
@group(0) @binding(11) var<storage, read_write> partial_energies: array<PartialEnergy>;
@group(0) @binding(12) var<storage, read_write> summaries: array<Summary>;
@group(0) @binding(13) var<storage, read> tissue: array<LocalTissue>;
@group(0) @binding(14) var<storage, read> lagged: array<Lagged>;
@group(0) @binding(15) var<storage, read> slips: array<vec4<f32>>;
@group(0) @binding(16) var<storage, read> frames: array<Frame>;
@group(0) @binding(17) var<uniform> material: MaterialParameters;

// As three vectors, which are summed at once and compiled faster than ten numbers.
fn packed(e: PartialEnergy) -> mat3x4<f32> {
    return mat3x4<f32>(
        vec4(e.inertia, e.gravity, e.elastic, e.damping),
        vec4(e.force, e.contact),
        vec4(e.friction, e.left_out, e.unforeseen, e.pressing),
    );
}

fn unpacked(e: mat3x4<f32>) -> PartialEnergy {
    return PartialEnergy(
        e[0].x, e[0].y, e[0].z, e[0].w, e[1].xyz, e[1].w, e[2].x, e[2].y, e[2].z, e[2].w,
    );
}

var<workgroup> threads: array<mat3x4<f32>, 64>;

// The sum over a workgroup in a fixed tree, in thread 0.
fn tree_sum(thread: u32, mine: mat3x4<f32>) -> PartialEnergy {
    threads[thread] = mine;
    workgroupBarrier();
    for (var width = 32u; width > 0u; width /= 2u) {
        if (thread < width) {
            threads[thread] += threads[thread + width];
        }
        workgroupBarrier();
    }
    return unpacked(threads[0]);
}

fn energy_of_point(i: u32, state: BatchState) -> PartialEnergy {
    let point = points[i];
    let from_start = !is_start(state.base, state.instance);
    let delta = motion[state.slot * constants.points + i].displacement;
    var e = -motion[state.instance * constants.points + i].displacement;
    if (from_start) {
        e += motion[state.base * constants.points + i].displacement;
    }
    var h = mat3x3<f32>();
    var increment = mat3x3<f32>();
    var base_increment = mat3x3<f32>();
    for (var k = 0u; k < point.handles; k++) {
        let u = handle_gradients[point.first_gradient + k];
        let phi = handles[state.slot * constants.handles + u.handle];
        h += outer(phi.displacement, u.gradient);
        increment += outer(phi.increment, u.gradient);
        if (from_start) {
            let base = handles[state.base * constants.handles + u.handle];
            base_increment += outer(base.increment, u.gradient);
        }
        let drift = handles[state.instance * constants.handles + u.handle].increment;
        base_increment -= outer(drift, u.gradient);
    }
    let mass = constants.density * point.measure;
    var out = PartialEnergy();
    out.inertia = 0.5 * mass * state.mass_rate * dot(delta, delta + 2.0 * e);
    out.gravity = -mass * dot(state.gravity, delta);
    let local = tissue[i];
    out.elastic = point.measure * stiffness_of(local, state)
        * energy_difference(h, increment, local.axes);
    let damping_rate = damping_rate_of(local, state);
    if (damping_rate > 0.0) {
        let start = tangent[state.instance * constants.points + i];
        out.damping = 0.5 * point.measure * damping_rate
            * double_dot(increment, contract(start, increment + 2.0 * base_increment));
    }
    return out;
}

// One thread a cubature point.
@compute @workgroup_size(64)
fn point_energy(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let i = 64u * group.x + thread;
    var mine = PartialEnergy();
    if (i < constants.points) {
        mine = energy_of_point(i, batch[chunk.first + group.y]);
    }
    let sum = tree_sum(thread, packed(mine));
    if (thread == 0u) {
        let stride = constants.point_groups + constants.vertex_groups;
        partial_energies[(chunk.first + group.y) * stride + group.x] = sum;
    }
}

// n of a lagged contact in a state
fn lagged_normal(contact: Lagged, slot: u32) -> vec3<f32> {
    if (contact.body == 0u) {
        return contact.normal;
    }
    return frames[slot * constants.bones + contact.body - 1u].rotation * contact.normal;
}

// |f(u) − f(u_base) − H(u_base) (u − u_base)| of a unit limit, f = f₀′(|u_T|) u_T/|u_T|
fn unforeseen(base: vec3<f32>, u: vec3<f32>, smoothing: f32) -> f32 {
    let y = length(base);
    let slopes = smoothed_slopes(y, smoothing);
    var along = vec3<f32>();
    if (y > 0.0) {
        along = base / y;
    }
    let change = u - base;
    let modelled = slopes.x * change + (slopes.y - slopes.x) * dot(along, change) * along;
    let force = smoothed_slopes(length(u), smoothing).x * u;
    return length(force - slopes.x * base - modelled);
}

// Adds the lagged contact `k` of the state's instance.
fn add_friction(k: u32, state: BatchState, out: ptr<function, PartialEnergy>) {
    let contact = lagged[lagged_header(state.instance) + 1u + k];
    var u = contact.start;
    var base_normal = contact.normal;
    if (!is_start(state.base, state.instance)) {
        u += slips[state.base * constants.contacts + k].xyz;
        base_normal = lagged_normal(contact, state.base);
    }
    let from_base = tangential(u, base_normal);
    let base = length(from_base);
    u = tangential(u + slips[state.slot * constants.contacts + k].xyz,
        lagged_normal(contact, state.slot));
    let y = length(u);
    (*out).friction += contact.limit * smoothed_difference(base, y, state.smoothing);
    (*out).force -= contact.limit * smoothed_slopes(y, state.smoothing).x * u;
    (*out).unforeseen += contact.limit * unforeseen(from_base, u, state.smoothing);
}

// One thread a skin vertex, which takes its share of the lagged contacts as well.
@compute @workgroup_size(64)
fn contact_energy(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let state = batch[chunk.first + group.y];
    let i = 64u * group.x + thread;
    var mine = PartialEnergy();
    if (i < constants.points) {
        for (var k = 0u; k < state.colliders; k++) {
            let here = distances[first_distance(state.slot, i, state.colliders) + k];
            let base = distances[first_distance(state.base, i, state.colliders) + k].w;
            let depth = max(here.w, 0.0);
            let base_depth = max(base, 0.0);
            let collider = colliders[state.instance * constants.colliders + k];
            let stiffness = contact_stiffness(collider, points[i], state);
            mine.contact += 0.5 * stiffness * (depth - base_depth) * (depth + base_depth);
            mine.force += stiffness * depth * here.xyz;
            mine.pressing += stiffness * depth;
            if ((depth > 0.0) != (base_depth > 0.0)) {
                mine.unforeseen += stiffness * max(depth, base_depth);
            }
            mine.left_out += f32(touches_but_is_left_out(here.w));
        }
    }
    let lagged_contacts = min(lagged[lagged_header(state.instance)].vertex, constants.contacts);
    for (var k = i; k < lagged_contacts; k += 64u * constants.vertex_groups) {
        add_friction(k, state, &mine);
    }
    let sum = tree_sum(thread, packed(mine));
    if (thread == 0u) {
        let stride = constants.point_groups + constants.vertex_groups;
        partial_energies[(chunk.first + group.y) * stride + constants.point_groups + group.x] = sum;
    }
}

// One workgroup a state.
@compute @workgroup_size(64)
fn energy(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let stride = constants.point_groups + constants.vertex_groups;
    let first = (chunk.first + group.y) * stride;
    var mine = mat3x4<f32>();
    for (var k = thread; k < stride; k += 64u) {
        mine += packed(partial_energies[first + k]);
    }
    let sum = tree_sum(thread, mine);
    let header = lagged_header(batch[chunk.first + group.y].instance);
    if (thread == 0u) {
        summaries[chunk.first + group.y] =
            Summary(sum, contacts[contact_header(group.y)].vertex, lagged[header].vertex);
    }
}
