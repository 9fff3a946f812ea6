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
