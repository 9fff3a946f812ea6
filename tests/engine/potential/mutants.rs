//! Parity is worth something only if it can fail: every edit here breaks one kernel, and the parity of that
//! kernel must notice.

use super::kernels::CHECKS;
use super::kernels::input::{avatar, seeds};
use super::kernels::scene::{Scene, device};
use supple::internal::gpu::Sources;
use supple::material::Material;
use supple::{Error, GpuError};

/// (check that must fail, file, text that occurs once, its replacement)
type Mutant = (&'static str, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const MUTANTS: &[Mutant] = &[
    // pose_blend
    ("pose_blend", "pose_blend.wgsl", "point.position + x", "point.position - x"),
    ("pose_blend", "pose_blend.wgsl", "pose_features[at * constants.features + k]", "pose_features[k]"),
    ("pose_blend", "pose_blend.wgsl", "pose_columns[c + 2u]", "pose_columns[c + 1u]"),
    ("pose_blend", "pose_blend.wgsl", "var k = 0u", "var k = 1u"),
    ("pose_blend", "pose_blend.wgsl", "state.instance * constants.points + i", "i"),
    ("pose_blend", "pose_blend.wgsl", "state.instance * constants.offset_vertices", "0u"),
    ("pose_blend", "pose_blend.wgsl", "let u = 3u * (first + influences[k].index)", "let u = 3u * first"),
    ("pose_blend", "pose_blend.wgsl", "pose_offsets[u + 2u]", "pose_offsets[u + 1u]"),
    ("pose_blend", "pose_blend.wgsl", "influences[k].weight * offset", "offset"),
    ("pose_blend", "pose_blend.wgsl", "k < point.first_share + point.shares", "k < point.first_share + 1u"),
    ("pose_blend", "pose_blend.wgsl", "var k = point.first_share", "var k = 0u"),
    // displacement
    ("displacement", "shared/point_motion.wgsl", "t_base - frames[f].joint", "t_base + frames[f].joint"),
    ("displacement", "shared/point_motion.wgsl", "rotation * t_increment", "t_increment * rotation"),
    ("displacement", "shared/point_motion.wgsl", "+ frames[f].position_increment", ""),
    ("displacement", "shared/point_motion.wgsl", "t_increment += u.weight * phi.increment", "t_increment += phi.increment"),
    ("displacement", "shared/point_motion.wgsl", "t_base += u.weight * phi.displacement", "t_base -= u.weight * phi.displacement"),
    ("displacement", "displacement.wgsl", "state.slot * constants.bones)", "0u)"),
    ("displacement", "shared/point_motion.wgsl", "Motion(d, t_base + t_increment, blended)", "Motion(d, t_base, blended)"),
    ("displacement", "displacement.wgsl", "unposed[state.instance * constants.points + i]", "unposed[i]"),
    ("displacement", "shared/point_motion.wgsl", "blended += w.weight * rotation", "blended += rotation"),
    // inertial_target
    ("inertial_target", "inertial_target.wgsl", "past.turn * (unposed - joint)", "past.turn * unposed"),
    ("inertial_target", "inertial_target.wgsl", "+ past.shift", ""),
    ("inertial_target", "inertial_target.wgsl", "past.first * first", "first * past.first"),
    ("inertial_target", "inertial_target.wgsl", "past.second * second", "past.first * second"),
    ("inertial_target", "inertial_target.wgsl", "+ past.third * third", ""),
    ("inertial_target", "inertial_target.wgsl", "second += u.weight * phi.second", "second += phi.second"),
    ("inertial_target", "inertial_target.wgsl", "third += u.weight * phi.third", "third += u.weight * phi.first"),
    ("inertial_target", "inertial_target.wgsl", "past_frames[state.instance * constants.bones + w.index]", "past_frames[w.index]"),
    ("inertial_target", "inertial_target.wgsl", "past_handles[state.instance * constants.handles + u.index]", "past_handles[u.index]"),
    // elasticity
    ("elasticity", "elasticity.wgsl", "phi.increment - drift(state, u.handle)", "phi.increment"),
    ("elasticity", "elasticity.wgsl", "handles[state.instance * constants.handles + handle].increment", "handles[handle].increment"),
    ("elasticity", "elasticity.wgsl", "outer(phi.displacement + phi.increment, u.gradient)", "outer(u.gradient, phi.displacement + phi.increment)"),
    ("elasticity", "elasticity.wgsl", "outer(phi.displacement + phi.increment, u.gradient)", "outer(phi.displacement, u.gradient)"),
    ("elasticity", "elasticity.wgsl", "p += damping_rate", "p -= damping_rate"),
    ("elasticity", "elasticity.wgsl", "add_scaled(c, damping_rate, start)", "add_scaled(c, 0.5 * damping_rate, start)"),
    ("elasticity", "elasticity.wgsl", "let damping_rate = damping_rate_of(local, state)", "let damping_rate = damping_rate_of(tissue[0], state)"),
    ("elasticity", "elasticity.wgsl", "tangent[state.instance * constants.points + i];", "tangent[i];"),
    ("elasticity", "shared/neo_hookean.wgsl", "return trace(h) + trace(cofactor(h)) + det(h)", "return trace(h) + trace(cofactor(h)) - det(h)"),
    ("elasticity", "shared/neo_hookean.wgsl", "h + transpose(h) - trace(h) * identity()", "h + transpose(h) + trace(h) * identity()"),
    ("elasticity", "shared/neo_hookean.wgsl", "+ ((lambda + mu) * volume_change(h))", "+ (lambda * volume_change(h))"),
    ("elasticity", "shared/neo_hookean.wgsl", "kappa * outer(a[1], a[0]) + p * skew(f[2])", "kappa * outer(a[1], a[0]) - p * skew(f[2])"),
    ("elasticity", "shared/neo_hookean.wgsl", "kappa * outer(a[2], a[0]) - p * skew(f[1])", "kappa * outer(a[2], a[0]) - p * skew(f[0])"),
    ("elasticity", "shared/neo_hookean_modes.wgsl", "min(mu + p * svd.sigma[k], 0.0)", "min(mu + p * svd.sigma[i], 0.0)"),
    ("elasticity", "shared/neo_hookean_modes.wgsl", "add_mode(c, -twist, ij - ji)", "add_mode(c, twist, ij - ji)"),
    ("elasticity", "shared/neo_hookean_modes.wgsl", "add_mode(c, -flip, ij + ji)", "add_mode(c, -flip, ij - ji)"),
    ("elasticity", "shared/neo_hookean_modes.wgsl", "let kappa = lambda + mu", "let kappa = lambda - mu"),
    ("elasticity", "shared/neo_hookean_modes.wgsl", "c = add_mode(c, -scaling.values[k], mode)", "c = add_mode(c, scaling.values[k], mode)"),
    ("elasticity", "shared/neo_hookean_modes.wgsl", "let gradient = s + (volume - 1.0) * area", "let gradient = s + volume * area"),
    ("elasticity", "shared/neo_hookean_modes.wgsl", "+ growth * outer(gradient, gradient)", ""),
    ("elasticity", "shared/neo_hookean_modes.wgsl", "shear_stress(h) + volume * cofactor(identity() + h)", "shear_stress(h)"),
    ("elasticity", "shared/neo_hookean_modes.wgsl", "add_mode(c, growth, shear_stress", "add_mode(c, 0.5 * growth, shear_stress"),
    ("elasticity", "material/stable_neo_hookean.wgsl", "material.mu, material.lambda, 0.0", "material.lambda, material.mu, 0.0"),
    ("elasticity", "material/stable_neo_hookean.wgsl", "material.mu, material.lambda, 0.0", "material.mu, material.lambda, material.mu"),
    ("elasticity", "material/fung_neo_hookean.wgsl", "trace(cofactor(h)) + det(h)", "trace(cofactor(h))"),
    ("elasticity", "material/fung_neo_hookean.wgsl", "+ volume * volume", ""),
    ("elasticity", "material/fung_neo_hookean.wgsl", "material.mu * exp(min(y, limit))", "material.mu * exp(y)"),
    ("elasticity", "material/fung_neo_hookean.wgsl", "material.mu * exp(min(y, limit))", "material.mu * exp(limit)"),
    ("elasticity", "material/fung_neo_hookean.wgsl", "second * (1.0 + max(y - limit, 0.0))", "second"),
    ("elasticity", "material/fung_neo_hookean.wgsl", "2.0 * material.stiffening * second", "material.stiffening * second"),
    ("elasticity", "material/fung_neo_hookean.wgsl", "neo_hookean_stress(h, stiffened(h).x, material.lambda)", "neo_hookean_stress(h, material.mu, material.lambda)"),
    ("elasticity", "material/fung_neo_hookean.wgsl", "s.x, material.lambda, s.y", "s.x, material.lambda, 0.0"),
    ("elasticity", "shared/neo_hookean.wgsl", "volume_change(h) - mu", "volume_change(h) + mu"),
    ("elasticity", "elasticity.wgsl", "var p = stiffness *", "var p ="),
    ("elasticity", "elasticity.wgsl", "scaled(projected_tangent(h, local.axes), stiffness)", "projected_tangent(h, local.axes)"),
    ("elasticity", "shared/tissue.wgsl", "return state.stiffness * local.stiffness", "return local.stiffness"),
    ("elasticity", "shared/tissue.wgsl", "return state.stiffness * local.stiffness", "return state.stiffness"),
    ("elasticity", "shared/tissue.wgsl", "1.0 + state.tension * local.muscle", "1.0 + state.tension"),
    ("elasticity", "shared/tissue.wgsl", "1.0 + state.tension * local.muscle", "1.0"),
    ("elasticity", "shared/tissue.wgsl", "local.stiffness * tensed(local, state)", "local.stiffness"),
    ("elasticity", "shared/tissue.wgsl", "local.damping_time / sqrt(tensed(local, state))", "local.damping_time"),
    ("elasticity", "shared/tissue.wgsl", "return state.damping_rate * local.damping_time", "return local.damping_time"),
    ("elasticity", "shared/tissue.wgsl", "return state.damping_rate * local.damping_time", "return state.damping_rate"),
    ("elasticity", "elasticity.wgsl", "let local = tissue[i]", "let local = tissue[0]"),
    ("elasticity", "shared/tensor.wgsl", "s * c.c20, s * c.c21", "s * c.c21, s * c.c20"),
    ("elasticity", "material/orthotropic.wgsl", "0.5 * (transpose(axes) * (h + transpose(h) + transpose(h) * h) * axes)", "0.5 * (axes * (h + transpose(h) + transpose(h) * h) * transpose(axes))"),
    ("elasticity", "material/orthotropic.wgsl", "0.5 * (transpose(axes) * (h + transpose(h) + transpose(h) * h) * axes)", "0.5 * (transpose(axes) * (h + transpose(h) + h * transpose(h)) * axes)"),
    ("elasticity", "material/orthotropic.wgsl", "material.saturation * exp(min(q, limit))", "material.saturation * exp(q)"),
    ("elasticity", "material/orthotropic.wgsl", "material.saturation * exp(min(q, limit))", "material.saturation * exp(limit)"),
    ("elasticity", "material/orthotropic.wgsl", "select(0.0, slope, q < limit)", "slope"),
    ("elasticity", "material/orthotropic.wgsl", "fibre_moduli() + slope * saturation_rates()", "fibre_moduli() + saturation_rates()"),
    ("elasticity", "material/orthotropic.wgsl", "outer(material.root_fibre_moduli, material.root_fibre_moduli)", "outer(material.root_fibre_moduli, material.root_fibre_moduli.yxz)"),
    ("elasticity", "material/orthotropic.wgsl", "outer(material.root_saturation_rates, material.root_saturation_rates)", "outer(material.root_saturation_rates, material.root_fibre_moduli)"),
    ("elasticity", "material/orthotropic.wgsl", "material.lambda) + s + h * s", "material.lambda) + s + s * h"),
    ("elasticity", "material/orthotropic.wgsl", "(w * e[i][j]) * identity()", "e[i][j] * identity()"),
    ("elasticity", "material/orthotropic.wgsl", "0.5 * w * outer(fg[j], fg[i])", "0.5 * w * outer(fg[i], fg[j])"),
    ("elasticity", "material/orthotropic.wgsl", "+ 2.0 * f.growth * outer(t[i], t[j])", "+ f.growth * outer(t[i], t[j])"),
    ("elasticity", "material/orthotropic.wgsl", "f.moduli[i].y * outer(fg[1], fg[1])", "f.moduli[i].y * outer(fg[2], fg[2])"),
    ("elasticity", "material/orthotropic.wgsl", "b[4u * i] += column_block(f, fg, i);", ""),
    ("elasticity", "material/orthotropic.wgsl", "axes[k][i] * axes[l][j]", "axes[i][k] * axes[j][l]"),
    ("elasticity", "material/orthotropic.wgsl", "let t = fg * f.direction", "let t = f.direction * fg"),
    ("elasticity", "material/orthotropic.wgsl", "return positive_part(add_scaled(ground, 1.0, fibres));", "return add_scaled(ground, 1.0, fibres);"),
    ("elasticity", "shared/positive_part.wgsl", "(*a)[9u * k + q] = r.z * kp + r.y * kq", "(*a)[9u * k + q] = r.z * kp - r.y * kq"),
    ("elasticity", "shared/positive_part.wgsl", "(*v)[9u * k + p] = r.y * vp - r.z * vq", "(*v)[9u * k + p] = r.y * vp + r.z * vq"),
    ("elasticity", "shared/positive_part.wgsl", "sweep < 7", "sweep < 1"),
    ("elasticity", "shared/positive_part.wgsl", "pivot -= l[9u * j + k] * l[9u * j + k]", "pivot += l[9u * j + k] * l[9u * j + k]"),
    ("elasticity", "shared/positive_part.wgsl", "add_mode(out, -value, mode)", "add_mode(out, value, mode)"),
    ("elasticity", "shared/positive_part.wgsl", "if (value < 0.0)", "if (value > 0.0)"),
    ("elasticity", "shared/decomposition.wgsl", "let theta = (qq - pp)", "let theta = (pp - qq)"),
    ("elasticity", "shared/decomposition.wgsl", "h + transpose(h) + transpose(h) * h", "h + transpose(h)"),
    ("elasticity", "shared/decomposition.wgsl", "dot(u2, f2)", "abs(dot(u2, f2))"),
    ("elasticity", "shared/tensor.wgsl", "c.c10 * a[0] + c.c11 * a[1] + a[2] * c.c21", "c.c10 * a[0] + c.c11 * a[1] + c.c21 * a[2]"),
    // contact
    ("contact", "contact.wgsl", "(p - position) * rotation", "rotation * (p - position)"),
    ("contact", "contact.wgsl", "rotation = body.rotation * collider.rotation", "rotation = collider.rotation * body.rotation"),
    ("contact", "contact.wgsl", "body.rotation * collider.position + body.position", "collider.position + body.position"),
    ("contact", "contact.wgsl", ".index == bone", ".index == bone + 100u"),
    ("contact", "contact.wgsl", "state.slot * constants.bones + collider.body - 1u", "collider.body - 1u"),
    ("contact", "contact.wgsl", "point.measure == 0.0", "point.measure < 0.0"),
    ("contact", "contact.wgsl", "collider.margin - d.distance", "d.distance - collider.margin"),
    ("contact", "contact.wgsl", "vec4(rotation * d.normal", "vec4(d.normal"),
    ("contact", "contact.wgsl", "colliders[state.instance * constants.colliders + k]", "colliders[k]"),
    ("contact", "shared/point_motion.wgsl", "unposed - frames[f].joint", "unposed + frames[f].joint"),
    ("contact", "shared/point_motion.wgsl", "phi.displacement + phi.increment", "phi.displacement"),
    ("contact", "shared/point_motion.wgsl", "+ frames[f].position);", ");"),
    ("contact", "collider/half_space.wgsl", "p.z", "p.y"),
    ("contact", "collider/sphere.wgsl", "ball.distance - parameters.x", "ball.distance + parameters.x"),
    ("contact", "collider/capsule.wgsl", "clamp(p.z, -parameters.y, parameters.y)", "clamp(p.z, -parameters.x, parameters.x)"),
    ("contact", "collider/cylinder.wgsl", "abs(p.z) - parameters.y", "abs(p.z) - parameters.x"),
    ("contact", "collider/cylinder.wgsl", "if (q.x > q.y)", "if (q.x < q.y)"),
    ("contact", "collider/mesh.wgsl", "node.z + MESH_NODES * grid", "node.y + MESH_NODES * grid"),
    ("contact", "collider/mesh.wgsl", "select(1.0 - t, t, side == vec3(1))", "select(t, 1.0 - t, side == vec3(1))"),
    ("contact", "collider/mesh.wgsl", "w.z * w.x, w.x * w.y", "w.z * w.y, w.x * w.y"),
    ("contact", "collider/mesh.wgsl", "slope /= parameters.xyz", "slope /= parameters.zyx"),
    ("contact", "collider/mesh.wgsl", "beyond / far, d + far", "beyond / far, d"),
    ("contact", "collider/box.wgsl", "out.normal * side", "out.normal"),
    ("contact", "collider/box.wgsl", "abs(p) - parameters.xyz", "abs(p) - parameters.zyx"),
    ("contact", "shared/contact.wgsl", "slot * constants.points * constants.colliders", "slot * constants.points"),
    // select
    ("select", "select.wgsl", "var room = constants.contacts", "var room = constants.contacts + 1u"),
    ("select", "select.wgsl", "key <= prefix", "key < prefix"),
    ("select", "select.wgsl", "bits | 0x80000000u, ~bits", "~bits, bits | 0x80000000u"),
    ("select", "select.wgsl", "24u - 8u * byte", "24u - 8u * min(byte, 2u)"),
    ("select", "select.wgsl", "room = here.y", "room = constants.contacts"),
    ("select", "select.wgsl", "(key & mask) == prefix", "true"),
    ("select", "select.wgsl", "0u, all(d == vec4(0.0))", "0u, false"),
    ("select", "contact.wgsl", "if (is_left_out(start))", "if (false)"),
    ("select", "shared/contact.wgsl", "2.0 * LEFT_OUT, depth > 0.0", "2.0 * LEFT_OUT, depth < 0.0"),
    // friction
    ("friction", "friction.wgsl", "collider.friction * force", "force"),
    ("friction", "friction.wgsl", "state) * d.w * slope", "state) * d.w"),
    ("friction", "friction.wgsl", "n = d.xyz / slope", "n = d.xyz"),
    ("friction", "friction.wgsl", "return colliders[collider].friction > 0.0 &&", "return"),
    ("friction", "friction.wgsl", "unposed[state.instance * constants.points + contact.vertex];\n    let moved", "unposed[contact.vertex];\n    let moved"),
    ("friction", "friction.wgsl", "let vertex = pair / state.colliders", "let vertex = pair % state.colliders"),
    ("friction", "friction.wgsl", "(p - body.position) * body.rotation", "body.rotation * (p - body.position)"),
    ("friction", "friction.wgsl", "contact.normal * body.rotation", "contact.normal"),
    ("friction", "friction.wgsl", "(p - collider.position) * collider.rotation", "p * collider.rotation"),
    ("friction", "friction.wgsl", "collider.rotation * n + collider.rotation_change * n", "collider.rotation * n"),
    ("friction", "friction.wgsl", "-(collider.rotation_change * a + collider.position_change)", "-collider.position_change"),
    ("friction", "shared/point_motion.wgsl", "t_increment += u.weight * phi.increment", "t_increment -= u.weight * phi.increment"),
    ("friction", "shared/point_motion.wgsl", "rotation * t_increment + frames[f].position_increment", "rotation * t_increment"),
    ("friction", "friction.wgsl", "u -= frames[f].rotation_increment * contact.anchor", "u += frames[f].rotation_increment * contact.anchor"),
    ("friction", "friction.wgsl", "slips[state.slot * constants.contacts + id.x]", "slips[id.x]"),
    ("friction", "shared/exclusive_sum.wgsl", "return counts[thread] - count", "return counts[thread]"),
    // compact
    ("compact", "compact.wgsl", "count += u32(distances[first + pair].w > 0.0)", "count += u32(distances[first + pair].w > 1e-3)"),
    ("compact", "shared/exclusive_sum.wgsl", "(thread + 1u) * length", "(thread + 1u) * length - 1u"),
    ("compact", "compact.wgsl", "let vertex = pair / state.colliders", "let vertex = pair % state.colliders"),
    ("compact", "compact.wgsl", "contact_stiffness(colliders[index], points[vertex], state)", "colliders[index].stiffness"),
    ("compact", "shared/contact_stiffness.wgsl", "min(point.contact_stiffness * state.stiffness, STIFFEST)", "point.contact_stiffness * state.stiffness"),
    ("compact", "shared/contact_stiffness.wgsl", "point.contact_stiffness * state.stiffness", "point.contact_stiffness"),
    ("compact", "shared/contact_stiffness.wgsl", "select(tissue, collider.stiffness,", "select(collider.stiffness, tissue,"),
    ("compact", "shared/contact_stiffness.wgsl", "* point.measure", ""),
    ("compact", "compact.wgsl", "Contact(d.xyz, -(k * d.w)", "Contact(d.xyz, k * d.w"),
    ("compact", "compact.wgsl", "+ 2u * lagged_contacts", "+ lagged_contacts"),
    ("compact", "compact.wgsl", ".rotation * n;", ".rotation * vec3(n.y, n.x, n.z);"),
    ("compact", "compact.wgsl", "tangential(contact.start + slip, n)", "tangential(slip, n)"),
    ("compact", "compact.wgsl", "slopes.x * y, slopes.y", "slopes.x * y, slopes.x"),
    ("compact", "compact.wgsl", "Contact(cross(n, along), 0.0, slopes.x", "Contact(cross(n, along), 0.0, slopes.y"),
    ("compact", "compact.wgsl", "slips[state.slot * constants.contacts + id.x]", "slips[id.x]"),
    ("compact", "compact.wgsl", "contact_rows[last - 1u] = -n", "contact_rows[last - 1u] = n"),
    ("compact", "compact.wgsl", "-cross(p - body.position, n)", "-cross(p, n)"),
    ("compact", "compact.wgsl", "constants.contact_blocks - 1u + block % 2u", "constants.contact_blocks - block % 2u"),
    ("compact", "shared/friction.wgsl", "return u - dot(n, u) * n", "return u + dot(n, u) * n"),
    ("compact", "shared/friction.wgsl", "2.0 * rest / smoothing", "rest / smoothing"),
    ("compact", "shared/friction.wgsl", "(1.0 + rest) / smoothing", "(2.0 + rest) / smoothing"),
    ("compact", "compact.wgsl", "w.weight * cross(frames[f].rotation * (t - frames[f].joint), n)", "w.weight * cross(n, frames[f].rotation * (t - frames[f].joint))"),
    ("compact", "compact.wgsl", "(n * frames[f].rotation)", "(frames[f].rotation * n)"),
    ("compact", "compact.wgsl", "= u.weight * unposed_normal", "= unposed_normal"),
    ("compact", "compact.wgsl", "k * 256u + place - 1u", "k * 256u + place"),
    ("compact", "compact.wgsl", "(8u * (block % 4u))", "(8u * (block % 3u))"),
    // gradient
    ("gradient", "gradient.wgsl", "moved.displacement - target_displacement", "moved.displacement + target_displacement"),
    ("gradient", "gradient.wgsl", "- state.gravity", "+ state.gravity"),
    ("gradient", "gradient.wgsl", "let mass = constants.density * point.measure", "let mass = constants.density"),
    ("gradient", "gradient.wgsl", "force * moved.blended", "moved.blended * force"),
    ("gradient", "gradient.wgsl", "+ weighted_stress * g", "- weighted_stress * g"),
    ("gradient", "gradient.wgsl", "cross(frames[f].rotation * (moved.unposed - frames[f].joint), force)", "cross(moved.unposed - frames[f].joint, force)"),
    ("gradient", "gradient.wgsl", "sum += contact.force * row", "sum -= contact.force * row"),
    ("gradient", "gradient.wgsl", "entry % 256u", "0u"),
    ("gradient", "gradient.wgsl", "width = 32u", "width = 16u"),
    ("gradient", "gradient.wgsl", "group.y * constants.local_blocks;", "0u;"),
    // point_hessian
    ("point_hessian", "point_hessian.wgsl", "j = -inertia * skew", "j = inertia * skew"),
    ("point_hessian", "point_hessian.wgsl", "constants.density * point.measure * state.mass_rate", "constants.density * state.mass_rate"),
    ("point_hessian", "point_hessian.wgsl", "let g = point.measure * own.xyz", "let g = own.xyz"),
    ("point_hessian", "point_hessian.wgsl", "g.x * c.c00 + g.y * transpose(c.c10)", "g.x * c.c00 + g.y * c.c10"),
    ("point_hessian", "point_hessian.wgsl", "other.y * y1 + other.z * y2", "other.z * y1 + other.y * y2"),
    ("point_hessian", "point_hessian.wgsl", "= transpose(h);", "= h;"),
    ("point_hessian", "point_hessian.wgsl", "transpose(blended) * j", "blended * j"),
    ("point_hessian", "point_hessian.wgsl", "half + u32(blocks % 2u == 1u || b < half)", "half"),
    ("point_hessian", "point_hessian.wgsl", "cross(other.xyz, j[1])", "cross(j[1], other.xyz)"),
    ("point_hessian", "point_hessian.wgsl", "h = other.w * j;", "h = j;"),
    ("point_hessian", "point_hessian.wgsl", "motion[at].unposed - frames[f].joint", "motion[at].unposed"),
    // hessian
    ("hessian", "hessian.wgsl", "sum += transpose(h)", "sum += h"),
    ("hessian", "hessian.wgsl", "let first = batch_row * constants.local_pairs", "let first = 0u"),
    ("hessian", "hessian.wgsl", "row * column.y", "row * column.z"),
    ("hessian", "hessian.wgsl", "let row = contact_rows[rows + here % 256u]", "let row = contact_rows[rows + there % 256u]"),
    ("hessian", "hessian.wgsl", "u32(contact <= there / 256u)", "1u"),
    ("hessian", "hessian.wgsl", "r <= row_end", "r < row_end"),
    ("hessian", "hessian.wgsl", "(batch_row * constants.blocks + column_block)", "(batch_row * constants.blocks + row_block)"),
    ("hessian", "hessian.wgsl", "sum += sums[thread + k]", "sum += sums[thread]"),
    ("hessian", "hessian.wgsl", "k < segment.count", "k + 1u < segment.count"),
    ("hessian", "hessian.wgsl", "|| is_prescribed(segment.column, state)", ""),
    ("hessian", "hessian.wgsl", "is_prescribed(segment.row, state) ||", ""),
    ("hessian", "hessian.wgsl", "prescribed[state * words", "prescribed[0u * words"),
    ("hessian", "hessian.wgsl", "let bone = block / 2u", "let bone = block"),
    // energy
    ("energy", "energy.wgsl", "base_increment -= outer(drift, u.gradient)", "base_increment += outer(drift, u.gradient)"),
    ("energy", "energy.wgsl", "handles[state.instance * constants.handles + u.handle].increment", "handles[u.handle].increment"),
    ("energy", "energy.wgsl", "dot(delta, delta + 2.0 * e)", "dot(delta, delta + e)"),
    ("energy", "energy.wgsl", "var e = -motion", "var e = motion"),
    ("energy", "energy.wgsl", "out.gravity = -mass", "out.gravity = mass"),
    ("energy", "energy.wgsl", "increment + 2.0 * base_increment", "increment + base_increment"),
    ("energy", "energy.wgsl", "(depth - base_depth) * (depth + base_depth)", "(depth - base_depth) * (depth - base_depth)"),
    ("energy", "energy.wgsl", "h += outer(phi.displacement, u.gradient)", "h += outer(phi.displacement + phi.increment, u.gradient)"),
    ("energy", "energy.wgsl", "let from_start = !is_start(state.base, state.instance)", "let from_start = true"),
    ("energy", "energy.wgsl", "mine.force += stiffness * depth * here.xyz", "mine.force -= stiffness * depth * here.xyz"),
    ("energy", "energy.wgsl", "constants.point_groups + group.x] = sum", "group.x] = sum"),
    ("energy", "energy.wgsl", "contact.limit * smoothed_difference", "smoothed_difference"),
    ("energy", "energy.wgsl", "(*out).force -=", "(*out).force +="),
    ("energy", "energy.wgsl", "u += slips[state.base * constants.contacts + k].xyz", "u = slips[state.base * constants.contacts + k].xyz"),
    ("energy", "energy.wgsl", "base_normal = lagged_normal(contact, state.base)", "base_normal = vec3(0.0)"),
    ("energy", "shared/friction.wgsl", "(s * s + s * b + b * b)", "(s * s + b * b)"),
    ("energy", "shared/friction.wgsl", "+ (y - s) - (base - b)", "+ (y - s)"),
    ("energy", "shared/neo_hookean.wgsl", "0.5 * double_dot(d, d) - s", "0.5 * double_dot(d, d) + s"),
    ("energy", "shared/neo_hookean.wgsl", "(2.0 * volume_change(h) + dj)", "(volume_change(h) + dj)"),
    ("energy", "energy.wgsl", "let damping_rate = damping_rate_of(local, state)", "let damping_rate = damping_rate_of(tissue[0], state)"),
    ("energy", "shared/tissue.wgsl", "local.damping_time / sqrt(tensed(local, state))", "local.damping_time / tensed(local, state)"),
    ("energy", "shared/tissue.wgsl", "local.stiffness * tensed(local, state)", "local.stiffness"),
    ("energy", "energy.wgsl", "point.measure * stiffness_of(local, state)", "point.measure"),
    ("energy", "energy.wgsl", "point.measure * stiffness_of(local, state)", "stiffness_of(local, state)"),
    ("energy", "material/fung_neo_hookean.wgsl", "2.0 * change.x + change.y", "2.0 * change.x"),
    ("energy", "material/fung_neo_hookean.wgsl", "+ material.lambda * change.y", ""),
    ("energy", "material/fung_neo_hookean.wgsl", "+ exp(limit) * (1.0 + 0.5 * beyond) * (1.0 - share)", ""),
    ("energy", "material/fung_neo_hookean.wgsl", "1.0 + 0.5 * beyond", "1.0 + beyond"),
    ("energy", "material/fung_neo_hookean.wgsl", "+ max(last - limit, 0.0)", ""),
    ("energy", "material/fung_neo_hookean.wgsl", "share = inner / whole", "share = whole / inner"),
    ("energy", "material/fung_neo_hookean.wgsl", "if (y >= limit)", "if (y >= 2.0 * limit)"),
    ("energy", "material/fung_neo_hookean.wgsl", "exp(min(y, limit)) * mean_exponential(inner)", "exp(min(y, limit))"),
    ("energy", "shared/exponential.wgsl", "return (exp(x) - 1.0) / x;", "return exp(x) / x;"),
    ("energy", "shared/exponential.wgsl", "1.0 + x / 2.0 * (1.0", "1.0 + x / 3.0 * (1.0"),
    ("energy", "material/orthotropic.wgsl", "let fd = d + transpose(h) * d", "let fd = d + h * d"),
    ("energy", "material/orthotropic.wgsl", "(fd + transpose(fd) + transpose(d) * d)", "(fd + transpose(fd))"),
    ("energy", "material/orthotropic.wgsl", "let between = 2.0 * e + change", "let between = e + change"),
    ("energy", "material/orthotropic.wgsl", "+ exp(limit) * (change - inner)", ""),
    ("energy", "material/orthotropic.wgsl", "exp(min(q, limit)) * (inner", "exp(limit) * (inner"),
    ("energy", "material/orthotropic.wgsl", "0.5 * (fibres + saturating)", "fibres + 0.5 * saturating"),
    ("energy", "material/orthotropic.wgsl", "if (q >= limit)", "if (q >= 2.0 * limit)"),
    // skin
    ("skin", "skin.wgsl", "unposed[at]", "unposed[i]"),
    ("skin", "skin.wgsl", "skinned_position(point, t, state.slot * constants.bones)", "skinned_position(point, t, 0u)"),
    ("skin", "skin.wgsl", "state.instance * constants.skin_stride", "state.instance * constants.points"),
    ("skin", "shared/point_motion.wgsl", "t += u.weight * (", "t -= u.weight * ("),
    // normals
    ("normals", "normals.wgsl", "n += cross", "n -= cross"),
    ("normals", "normals.wgsl", "constants.skin_stride", "constants.points"),
    ("normals", "normals.wgsl", "skin_vertices[first + edge.y].position - v)", "skin_vertices[first + edge.y].position)"),
    ("normals", "normals.wgsl", "var k = one_ring_rows[i]", "var k = one_ring_rows[i] + 1u"),
    ("normals", "normals.wgsl", "n / length", "n"),
];

/// Two scenes of each material that uses the file `path`, the plainest first.
fn seeds_that_see(path: &str) -> Vec<u64> {
    let is_material = |p: &&str| *p == path;
    let of_some = Material::examples()
        .iter()
        .any(|m| m.kernels().iter().any(&is_material));
    let uses = |seed: &u64| !of_some || avatar(*seed).material.kernels().contains(&path);
    seeds(2).into_iter().filter(uses).collect()
}

#[test]
fn parity_notices_every_mutant() {
    let gpu = device();
    let mut survivors = Vec::new();
    for (number, &(name, path, from, to)) in MUTANTS.iter().enumerate() {
        let (_, check) = (CHECKS.iter())
            .find(|(check, _)| *check == name)
            .unwrap_or_else(|| panic!("there is no check `{name}`"));
        let mutant = format!("{number}: {path}: `{from}` → `{to}`");
        let noticed = seeds_that_see(path).into_iter().any(|seed| {
            let material = avatar(seed).material;
            let sources = Sources::new(&material)
                .edited(path, from, to)
                .unwrap_or_else(|e| panic!("{mutant}: {e}"));
            match Scene::run(&gpu, seed, Some(sources)) {
                Ok(scene) => check(&scene).is_err(),
                Err(error @ Error::Gpu(GpuError::Shader { .. })) => panic!("{mutant}: {error}"),
                // Not finite, or more contacts than there is room for: nobody could overlook that.
                Err(_) => true,
            }
        });
        if !noticed {
            survivors.push(mutant);
        }
    }
    assert!(
        survivors.is_empty(),
        "not noticed:\n{}",
        survivors.join("\n")
    );
}

#[test]
fn every_kernel_has_mutants() {
    for (name, _) in CHECKS {
        let count = MUTANTS.iter().filter(|(check, ..)| check == name).count();
        assert!(count >= 3, "{name} has {count}");
    }
    let material = avatar(1).material;
    for path in Sources::new(&material).paths() {
        let mutated = MUTANTS.iter().any(|(_, file, ..)| *file == path);
        let declarations_only = [
            "shared/batch.wgsl",
            "shared/kinematics.wgsl",
            "shared/distance.wgsl",
        ];
        assert!(
            mutated || declarations_only.contains(&path),
            "{path} has no mutant"
        );
    }
}
