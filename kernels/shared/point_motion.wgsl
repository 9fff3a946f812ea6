// Needs: influences, frames, handles.

// T = x̄ + Σ_h U_h (φ_base + Δφ)_h
fn unposed_position(point: Point, rest: vec3<f32>, first_handle: u32) -> vec3<f32> {
    var t = rest;
    let first = point.first_influence + point.bones;
    for (var k = 0u; k < point.handles; k++) {
        let u = influences[first + k];
        let phi = handles[first_handle + u.index];
        t += u.weight * (phi.displacement + phi.increment);
    }
    return t;
}

// x = Σ_j w_j ( R_j (T − J_j) + c_j ), c relative to the origin
fn skinned_position(point: Point, unposed: vec3<f32>, first_frame: u32) -> vec3<f32> {
    var x = vec3<f32>();
    for (var k = 0u; k < point.bones; k++) {
        let w = influences[point.first_influence + k];
        let f = first_frame + w.index;
        x += w.weight * (frames[f].rotation * (unposed - frames[f].joint) + frames[f].position);
    }
    return x;
}

// What displacements are measured by: from increments only, never from two world positions,
//   T_base = x̄ + Σ U φ_base,  ΔT = Σ U Δφ,  d = Σ_j w_j ( ΔR_j (T_base − J_j) + R_j ΔT + Δc_j )
// with T = T_base + ΔT and B = Σ_j w_j R_j.
fn motion_since_base(point: Point, rest: vec3<f32>, first_handle: u32, first_frame: u32) -> Motion {
    var t_base = rest;
    var t_increment = vec3<f32>();
    for (var k = 0u; k < point.handles; k++) {
        let u = influences[point.first_influence + point.bones + k];
        let phi = handles[first_handle + u.index];
        t_base += u.weight * phi.displacement;
        t_increment += u.weight * phi.increment;
    }
    var d = vec3<f32>();
    var blended = mat3x3<f32>();
    for (var k = 0u; k < point.bones; k++) {
        let w = influences[point.first_influence + k];
        let f = first_frame + w.index;
        let rotation = frames[f].rotation;
        d += w.weight * (frames[f].rotation_increment * (t_base - frames[f].joint)
            + rotation * t_increment + frames[f].position_increment);
        blended += w.weight * rotation;
    }
    return Motion(d, t_base + t_increment, blended);
}
