//! The bone press benchmark's limb: a soft cylinder shell around a rigid bone, cut at both ends.

use super::{Body, LayerMesh};
use glam::DVec3;
use std::f64::consts::TAU;
use supple::internal::math::Rows;
use supple::model::{JointList, PoseBlend, Skeleton, SkinWeight, Surface, TetMesh, UpAxis};
use supple::{Error, Result};

/// A cylinder shell about the x axis, m, and how finely it is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limb {
    /// From x = 0 to x = `length`.
    pub length: f64,
    /// Radius of the bone.
    pub inner_radius: f64,
    /// Radius of the skin.
    pub outer_radius: f64,
    /// Cells along the axis.
    pub stations: usize,
    /// Cells from bone to skin.
    pub layers: usize,
    /// Cells around the axis; even.
    pub sectors: usize,
}

impl Limb {
    /// The benchmark's mesh S: 2,080 nodes, 7,500 tets.
    pub const S: Self = Self::with_cells(25, 3, 20);
    /// The benchmark's mesh M: 10,176 nodes, 41,600 tets.
    pub const M: Self = Self::with_cells(52, 5, 32);

    const fn with_cells(stations: usize, layers: usize, sectors: usize) -> Self {
        Self {
            length: 0.25,
            inner_radius: 0.015,
            outer_radius: 0.04,
            stations,
            layers,
            sectors,
        }
    }

    /// The mesh, the bone's nodes and the skin's nodes.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a measure is not positive, the radii are not nested, or there are no
    /// cells or an odd number of sectors.
    pub fn mesh(&self) -> Result<(TetMesh, Vec<u32>, Vec<u32>)> {
        self.validate()?;
        let &Self {
            stations,
            layers,
            sectors,
            ..
        } = self;
        let (across, along) = (layers as f64, stations as f64);
        let node =
            |i: usize, j: usize, k: usize| ((i * (layers + 1) + j) * sectors + k % sectors) as u32;
        let mut mesh = TetMesh::default();
        for i in 0..=stations {
            for j in 0..=layers {
                let radius =
                    self.inner_radius + (self.outer_radius - self.inner_radius) * j as f64 / across;
                for k in 0..sectors {
                    let (sine, cosine) = (TAU * k as f64 / sectors as f64).sin_cos();
                    let x = self.length * i as f64 / along;
                    mesh.nodes
                        .push(DVec3::new(x, radius * sine, radius * cosine));
                }
            }
        }
        for i in 0..stations {
            for j in 0..layers {
                for k in 0..sectors {
                    // Corner bits: 4 along, 2 outward, 1 around.
                    let corner = |c: usize| node(i + (c >> 2), j + (c >> 1 & 1), k + (c & 1));
                    mesh.tets
                        .extend(five_tets((i + j + k) % 2).map(|tet| tet.map(corner)));
                }
            }
        }
        let ring = |j: usize| {
            (0..=stations)
                .flat_map(|i| (0..sectors).map(move |k| (i, k)))
                .map(|(i, k)| node(i, j, k))
                .collect()
        };
        Ok((mesh, ring(0), ring(layers)))
    }

    /// The limb as a body of one bone.
    ///
    /// # Errors
    /// As [`Limb::mesh`].
    pub fn body(&self) -> Result<Body> {
        let (mesh, pinned, surface) = self.mesh()?;
        one_bone_body("limb", mesh, &pinned, &surface)
    }

    fn validate(&self) -> Result<()> {
        let measures = self.length > 0.0
            && self.inner_radius > 0.0
            && self.outer_radius > self.inner_radius
            && (self.length + self.outer_radius).is_finite();
        if !measures {
            return Err(Error::invalid(
                "limb",
                "needs a positive length and 0 < inner radius < outer radius (m)",
            ));
        }
        let cells = [self.stations, self.layers, self.sectors];
        if cells.contains(&0) || cells.iter().any(|&n| n > 1024) {
            return Err(Error::invalid("limb", "needs 1 to 1024 cells each way"));
        }
        // Diagonals alternate, and the last sector meets the first.
        if self.sectors % 2 == 1 || self.sectors < 4 {
            return Err(Error::invalid("limb.sectors", "must be even, 4 or more"));
        }
        Ok(())
    }
}

/// The five tets of a cell over its corner bits: one at each corner of the other parity, and the one
/// between the corners whose bits sum to `parity`. Neighbours of opposite parity share diagonals.
fn five_tets(parity: usize) -> [[usize; 4]; 5] {
    // Reflection of one axis turns one parity into the other, and the orientation round.
    let even = [
        [0, 1, 3, 5],
        [0, 3, 2, 6],
        [0, 5, 6, 4],
        [3, 6, 5, 7],
        [0, 3, 6, 5],
    ];
    match parity {
        0 => even,
        _ => even.map(|[a, b, c, d]| [a ^ 1, b ^ 1, d ^ 1, c ^ 1]),
    }
}

/// A body around one bone from a mesh with its `pinned` and `surface` nodes: a generated limb, or one
/// from a file. The joint is the middle of the pinned nodes.
///
/// # Errors
/// [`Error::Invalid`] where a list is empty or names a node that is not there, or no boundary face
/// lies on the surface.
pub fn one_bone_body(name: &str, mesh: TetMesh, pinned: &[u32], surface: &[u32]) -> Result<Body> {
    let count = mesh.nodes.len();
    for (field, list) in [("pinned", pinned), ("surface", surface)] {
        if list.is_empty() || list.iter().any(|&n| n as usize >= count) {
            let problem = format!("needs some nodes, all below {count}");
            return Err(Error::invalid(field, problem));
        }
    }
    let mut bone_of_node = vec![None; count];
    pinned
        .iter()
        .for_each(|&n| bone_of_node[n as usize] = Some(0));
    let mut vertex_of_node = vec![None; count];
    for (v, &n) in surface.iter().enumerate() {
        vertex_of_node[n as usize] = Some(v as u32);
    }
    let on_surface = |[a, b, c]: [u32; 3]| {
        let vertex = |n: u32| vertex_of_node[n as usize];
        Some([vertex(a)?, vertex(b)?, vertex(c)?])
    };
    let triangles: Vec<_> = (mesh.boundary_triangles().into_iter())
        .filter_map(on_surface)
        .collect();
    if triangles.is_empty() {
        return Err(Error::invalid("surface", "holds no whole boundary face"));
    }
    let place = |&n: &u32| mesh.nodes[n as usize];
    let joint = pinned.iter().map(place).sum::<DVec3>() / pinned.len() as f64;
    let skeleton = Skeleton {
        aliases: Vec::new(),
        limits: Vec::new(),
        names: vec!["bone".into()],
        parents: vec![None],
        joints: vec![joint],
    };
    let body = Body {
        name: name.into(),
        joints: JointList::of_bones(&skeleton),
        springs: Default::default(),
        up: UpAxis::Z,
        skeleton,
        skin: Surface {
            positions: surface.iter().map(place).collect(),
            triangles,
        },
        skinning: (surface.iter())
            .map(|_| {
                [SkinWeight {
                    bone: 0,
                    weight: 1.0,
                }]
            })
            .collect(),
        pose_blend: PoseBlend::default(),
        bone_surfaces: Vec::new(),
        layer: LayerMesh {
            tissue_fraction: vec![1.0; mesh.tets.len()],
            bone_of_node,
            skin_embedding: surface.iter().map(|&n| [(n, 1.0)]).collect::<Rows<_>>(),
            mesh,
        },
        painted: Default::default(),
        attachments: Vec::new(),
        render_meshes: Vec::new(),
        appearance: Default::default(),
    };
    body.validate()?;
    Ok(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Volume of the shell between two regular n-gon prisms.
    fn prism_volume(limb: &Limb) -> f64 {
        let n = limb.sectors as f64;
        let polygon = 0.5 * n * (TAU / n).sin();
        polygon * (limb.outer_radius.powi(2) - limb.inner_radius.powi(2)) * limb.length
    }

    #[test]
    fn counts_volume_and_boundary() {
        for (limb, nodes, tets, ring) in [(Limb::S, 2080, 7500, 520), (Limb::M, 10176, 41600, 1696)]
        {
            let body = limb.body().unwrap();
            let mesh = &body.layer.mesh;
            assert_eq!((mesh.nodes.len(), mesh.tets.len()), (nodes, tets));
            assert_eq!(body.layer.bone_of_node.iter().flatten().count(), ring);
            assert_eq!(body.skin.positions.len(), ring);
            assert_eq!(body.skin.triangles.len(), 2 * limb.stations * limb.sectors);
            assert_relative_eq!(
                body.layer.tissue_volume(),
                prism_volume(&limb),
                max_relative = 1e-12
            );
            let outward = |t: usize| {
                let centre = body.skin.corners(t).iter().sum::<DVec3>() / 3.0;
                body.skin.area_vector(t).dot(centre.with_x(0.0)) > 0.0
            };
            assert!((0..body.skin.triangles.len()).all(outward));
            // Conforming: the boundary is one closed surface, a torus here.
            let boundary = Surface {
                positions: mesh.nodes.clone(),
                triangles: mesh.boundary_triangles(),
            };
            assert!(boundary.is_closed());
            assert_relative_eq!(boundary.volume(), prism_volume(&limb), max_relative = 1e-12);
        }
    }

    #[test]
    fn bad_measures_are_errors() {
        for limb in [
            Limb {
                sectors: 21,
                ..Limb::S
            },
            Limb {
                layers: 0,
                ..Limb::S
            },
            Limb {
                outer_radius: 0.01,
                ..Limb::S
            },
            Limb {
                length: f64::NAN,
                ..Limb::S
            },
        ] {
            assert!(matches!(limb.body(), Err(Error::Invalid { .. })));
        }
        let (mesh, pinned, _) = Limb::S.mesh().unwrap();
        assert!(one_bone_body("limb", mesh.clone(), &pinned, &[]).is_err());
        assert!(one_bone_body("limb", mesh, &pinned, &[u32::MAX]).is_err());
    }
}
