//! Random input whose numbers are exact in f32, so that both sides compute from the same.

use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::internal::math::{Random, Rows};
use supple::internal::random_avatar;
use supple::material::{FungNeoHookean, Material, Orthotropic, StableNeoHookean};
use supple::model::{Avatar, BasisEntry, Frame, SkinWeight};

fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

fn single_vec(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

/// Seeds whose avatars are of each material: a hundred a material.
pub fn seeds(count: u64) -> Vec<u64> {
    (0..3)
        .flat_map(|m| (1..=count).map(move |s| 100 * m + s))
        .collect()
}

/// How far out handles are: the farther, the more of the points are inverted and past the clamp, and the less a bound
/// says of those that are not.
pub fn reach(seed: u64) -> f64 {
    if [102, 202].contains(&seed) {
        8.0
    } else {
        40.0
    }
}

/// Compressible, so that terms of the volume do not hide those of the shape; saturating over the strains that occur.
fn material(seed: u64) -> Material {
    let (youngs_modulus, poissons_ratio) = (3e4, 0.1);
    match seed / 100 {
        0 => Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus,
            poissons_ratio,
        }),
        1 => Material::Orthotropic(Orthotropic {
            youngs_modulus,
            poissons_ratio,
            fibre_moduli: [5e3, 2e4, 1e4],
            saturation: 1e4,
            saturation_rates: [0.25, 0.5, 1.0],
            saturation_limit: 1.5,
        }),
        _ => {
            // One is so steep that the exponent changes by more than ½ in a step.
            let (stiffening, stiffening_limit) = match seed {
                201 => (0.5, 1.0),
                202 => (10.0, 4.0),
                _ => (0.5, 2.0),
            };
            Material::FungNeoHookean(FungNeoHookean {
                youngs_modulus,
                poissons_ratio,
                stiffening,
                stiffening_limit,
            })
        }
    }
}

/// The frame without tissue.
pub const BODY: u32 = 5;

/// A random avatar whose numbers are exact in f32, some points naming their bones in falling order.
pub fn avatar(seed: u64) -> Avatar {
    let mut avatar = random_avatar(seed, 5, 9, 90, 150);
    avatar.material = material(seed);
    for local in &mut avatar.tissue {
        local.stiffness = single(local.stiffness);
        local.damping_time = single(local.damping_time);
        local.muscle = single(local.muscle);
    }
    for joint in &mut avatar.skeleton.joints {
        *joint = single_vec(*joint);
    }
    for set in [&mut avatar.cubature, &mut avatar.skin] {
        set.position.iter_mut().for_each(|x| *x = single_vec(*x));
        set.measure.iter_mut().for_each(|m| *m = single(*m));
        let weight = |w: &SkinWeight| SkinWeight {
            weight: single(w.weight),
            ..*w
        };
        let entry = |u: &BasisEntry| BasisEntry {
            value: single(u.value),
            gradient: single_vec(u.gradient),
            ..*u
        };
        set.skinning = some_reversed(&set.skinning.map(weight));
        set.basis = set.basis.map(entry);
    }
    with_body(avatar)
}

/// `avatar` with a frame more, a body without tissue that carries colliders and has a few vertices of the skin.
fn with_body(mut avatar: Avatar) -> Avatar {
    let body = avatar.skeleton.len() as u32;
    avatar.skeleton.names.push("body".into());
    avatar.skeleton.parents.push(None);
    avatar.skeleton.joints.push(DVec3::splat(0.015625));
    avatar.bone_masses.push(avatar.bone_masses[0]);
    let whole = [SkinWeight {
        bone: body,
        weight: 1.0,
    }];
    let skin = &mut avatar.skin;
    let skinning = skin.skinning.iter().enumerate();
    skin.skinning = skinning
        .map(|(v, row)| if v < 6 { whole.to_vec() } else { row.to_vec() })
        .collect();
    let basis = skin.basis.iter().enumerate();
    skin.basis = basis
        .map(|(v, row)| if v < 6 { Vec::new() } else { row.to_vec() })
        .collect();
    avatar
}

fn some_reversed(rows: &Rows<SkinWeight>) -> Rows<SkinWeight> {
    let row = |(i, row): (usize, &[SkinWeight])| {
        let mut row = row.to_vec();
        if i % 3 == 1 {
            row.reverse();
        }
        row
    };
    rows.iter().enumerate().map(row).collect()
}

/// One collider of every shape, set so that parts of the skin touch it.
pub fn colliders(seed: u64, origin: DVec3) -> Vec<Collider> {
    let random = &mut Random::new(seed ^ 0x5eed);
    let collider = |shape: Shape| {
        let offset = match shape {
            Shape::HalfSpace => DVec3::ZERO,
            _ => random.vector(0.03),
        };
        let frame = Frame {
            rotation: random.rotation(3.0),
            position: origin + offset,
        };
        Collider {
            stiffness: Some(single(random.uniform(1e6, 2e6))),
            margin: single(random.uniform(2e-3, 6e-3)),
            friction: 0.5,
            previous: frame.moved(random.vector(1e-3), random.vector(0.02)),
            ..Collider::new(rounded_shape(shape), frame)
        }
    };
    let mut colliders: Vec<_> = Shape::examples().into_iter().map(collider).collect();
    // Every other one is carried by the body, the last frame; one is smooth.
    for collider in colliders.iter_mut().step_by(2) {
        collider.frame.position -= origin;
        collider.body = Some(BODY);
    }
    colliders[1].friction = 0.0;
    // Two of them, one of which is rough and one carried, take the tissue's stiffness.
    (colliders[3].stiffness, colliders[4].stiffness) = (None, None);
    colliders
}

fn rounded_shape(shape: Shape) -> Shape {
    match shape {
        Shape::HalfSpace => Shape::HalfSpace,
        Shape::Sphere { radius } => Shape::Sphere {
            radius: single(radius),
        },
        Shape::Capsule {
            radius,
            half_length,
        } => Shape::Capsule {
            radius: single(radius),
            half_length: single(half_length),
        },
        Shape::Cylinder {
            radius,
            half_length,
        } => Shape::Cylinder {
            radius: single(radius),
            half_length: single(half_length),
        },
        Shape::Box { half_extents } => Shape::Box {
            half_extents: half_extents.map(single),
        },
        // Its samples are in f32, and so are its spacings.
        Shape::Mesh(mesh) => Shape::Mesh(mesh),
    }
}

pub fn rounded_collider(c: Collider) -> Collider {
    let frame = Frame {
        rotation: c.frame.rotation.as_mat3().as_dmat3(),
        position: single_vec(c.frame.position),
    };
    Collider { frame, ..c }
}
