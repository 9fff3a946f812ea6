// d trilinear between the nodes of a grid of 48³ in the collider's own frame, whose origin is the grid's
// first node; n = ∇d. Beyond the grid the distance from it is added.
// parameters = (spacing along x, y, z, index of the grid)
@group(0) @binding(20) var distance_grids: texture_3d<f32>;

const MESH_NODES = 48;

fn grid_value(node: vec3<i32>, grid: i32) -> f32 {
    return textureLoad(distance_grids, vec3(node.xy, node.z + MESH_NODES * grid), 0).x;
}

fn mesh_distance(parameters: vec4<f32>, p: vec3<f32>) -> SignedDistance {
    let grid = i32(parameters.w);
    let at = p / parameters.xyz;
    let within = clamp(at, vec3(0.0), vec3(f32(MESH_NODES - 1)));
    let first = min(vec3<i32>(floor(within)), vec3(MESH_NODES - 2));
    let t = within - vec3<f32>(first);
    var d = 0.0;
    var slope = vec3<f32>();
    for (var c = 0; c < 8; c++) {
        let side = vec3(c & 1, (c >> 1u) & 1, c >> 2u);
        let value = grid_value(first + side, grid);
        let w = select(1.0 - t, t, side == vec3(1));
        let sign = select(vec3(-1.0), vec3(1.0), side == vec3(1));
        d += value * w.x * w.y * w.z;
        slope += value * sign * vec3(w.y * w.z, w.z * w.x, w.x * w.y);
    }
    slope /= parameters.xyz;
    let beyond = (at - within) * parameters.xyz;
    let far = length(beyond);
    if (far == 0.0) {
        return SignedDistance(slope, d);
    }
    return SignedDistance(select(vec3(0.0), slope, beyond == vec3(0.0)) + beyond / far, d + far);
}
