//! Vertices and triangles of the meshes that a scene shows (glTF 2.0, §3.7).

use super::appearance::highest_coordinates;
use super::compression::DracoMesh;
use super::container::File;
use super::document::{Mesh, Node, Primitive};
use super::nodes::Nodes;
use super::triangles::{Used, assemble};
use glam::DVec3;
use serde_json::Value;
use std::collections::BTreeMap;
use supple::Result;
use supple::internal::math::Rows;

/// Most sets of four joints a vertex.
const MOST_SETS: usize = 16;

/// A primitive as one node shows it, in the mesh's own coordinates, without vertices that no triangle
/// uses.
#[derive(Debug)]
pub(super) struct Part {
    pub name: String,
    pub material: String,
    pub material_index: Option<u32>,
    /// The node that shows it.
    pub node: usize,
    pub skin: Option<usize>,
    pub positions: Vec<DVec3>,
    /// Joints of the skin and weights that sum to 1; empty rows without a skin.
    pub influences: Rows<(u32, f64)>,
    pub texture_coordinates: Vec<[f32; 2]>,
    /// Those that the material names besides.
    pub further_coordinates: Vec<Vec<[f32; 2]>>,
    /// Unit vectors, or none at all.
    pub normals: Vec<[f64; 3]>,
    /// Unit vectors and signs, or none at all.
    pub tangents: Vec<[f64; 4]>,
    /// Red, green, blue and opacity, or none at all.
    pub colours: Vec<[f32; 4]>,
    pub triangles: Vec<[u32; 3]>,
    pub morphs: Vec<Morph>,
    /// Application-specific scalars of the vertices (`_NAME`), by lower-case name.
    pub painted: BTreeMap<String, Vec<f64>>,
    /// Vertices whose weights are all 0: the skin's first joint has them.
    pub unweighted: usize,
}

/// A morph target.
#[derive(Debug)]
pub(super) struct Morph {
    pub name: String,
    /// Its weight where nothing else is said.
    pub default: f64,
    /// Vertices that it moves, rising, with the displacement at weight 1.
    pub moves: Vec<(u32, DVec3)>,
}

/// All parts that the scene shows, in the order of its nodes, and how many primitives of points and
/// lines were left out.
pub(super) fn read_parts(file: &File, nodes: &Nodes) -> Result<(Vec<Part>, usize)> {
    let mut parts = Vec::new();
    let mut skipped = 0;
    for (n, node) in file.document.nodes.iter().enumerate() {
        let Some(m) = node.mesh.filter(|_| nodes.shown[n]) else {
            continue;
        };
        let mesh = file.document.meshes.get(m);
        let missing = || file.broken(format!("nodes[{n}].mesh"), format!("mesh {m} is not there"));
        let mesh = mesh.ok_or_else(missing)?;
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let field = format!("meshes[{m}].primitives[{p}]");
            let draco = file.draco(primitive);
            let draco = draco.map_err(|problem| file.broken(&field, problem))?;
            let reader = Reader {
                file,
                field,
                primitive,
                draco,
            };
            match reader.part(n, node, mesh)? {
                Some(part) => parts.push(part),
                None => skipped += 1,
            }
        }
    }
    Ok((parts, skipped))
}

struct Reader<'a> {
    file: &'a File,
    field: String,
    primitive: &'a Primitive,
    /// What its Draco data are, if it has some.
    draco: Option<DracoMesh>,
}

impl Reader<'_> {
    fn broken(&self, problem: impl Into<String>) -> supple::Error {
        self.file.broken(&self.field, problem)
    }

    /// The part, unless the primitive has no triangles.
    fn part(&self, n: usize, node: &Node, mesh: &Mesh) -> Result<Option<Part>> {
        let mode = self.primitive.mode.unwrap_or(4);
        if mode > 6 {
            return Err(self.broken(format!("mode {mode} is none of glTF's")));
        }
        let Some(&position) = self.primitive.attributes.get("POSITION") else {
            return Err(self.broken("has no POSITION"));
        };
        let (positions, indices) = match &self.draco {
            Some(mesh) => {
                let positions = self.attribute::<3>(("POSITION", position), mesh.points())?;
                (positions, mesh.indices().map_err(|p| self.broken(p))?)
            }
            None => {
                let positions = self.file.vectors::<3>(position)?;
                let indices = match self.primitive.indices {
                    Some(accessor) => self.file.indices(accessor, positions.len())?,
                    None => (0..positions.len() as u32).collect(),
                };
                (positions, indices)
            }
        };
        let count = positions.len();
        let Some(triangles) = assemble(&indices, mode) else {
            return Ok(None);
        };
        let used = Used::new(count, &triangles);
        if used.vertices.is_empty() {
            return Ok(None);
        }
        let (influences, unweighted) = match node.skin {
            Some(skin) => self.influences(skin, count, &used)?,
            None => (used.vertices.iter().map(|_| None).collect(), 0),
        };
        let materials = self.file.document.materials.as_slice();
        let material = self.primitive.material.and_then(|m| materials.get(m));
        Ok(Some(Part {
            name: (mesh.name.as_ref().or(node.name.as_ref()))
                .map_or_else(|| format!("mesh_{n}"), Clone::clone),
            material_index: (self.primitive.material)
                .filter(|_| material.is_some())
                .map(|m| m as u32),
            material: (material.and_then(|m| m.get("name")?.as_str()))
                .unwrap_or_default()
                .into(),
            node: n,
            skin: node.skin,
            positions: used.pick(&positions).map(DVec3::from_array).collect(),
            influences,
            texture_coordinates: self.texture_coordinates(0, count, &used)?,
            further_coordinates: (1..=material.map_or(0, highest_coordinates))
                .map(|set| self.texture_coordinates(set, count, &used))
                .collect::<Result<_>>()?,
            normals: self.vectors("NORMAL", count, &used)?,
            tangents: self.vectors("TANGENT", count, &used)?,
            colours: self.colours(count, &used)?,
            triangles: used.renumber(&triangles),
            morphs: self.morphs(node, mesh, count, &used)?,
            painted: self.painted(count, &used)?,
            unweighted,
        }))
    }

    /// An attribute's elements, one for each of `count` vertices.
    fn attribute<const N: usize>(
        &self,
        (name, accessor): (&str, usize),
        count: usize,
    ) -> Result<Vec<[f64; N]>> {
        let found = self.file.document.accessors.get(accessor);
        let compressed = self.primitive.extensions.draco.as_ref();
        let compressed = compressed.and_then(|d| d.attributes.get(name));
        if let (Some(mesh), Some(&id), Some(found)) = (&self.draco, compressed, found) {
            let vectors = self.file.draco_vectors(mesh, id, found);
            return vectors.map_err(|problem| self.broken(format!("{name}: {problem}")));
        }
        // Before anything is read: a sparse accessor's count costs nothing in the file.
        if let Some(found) = found.filter(|a| a.count != count as u64) {
            let problem = format!("{name} has {} elements for {count} vertices", found.count);
            return Err(self.broken(problem));
        }
        self.file.vectors(accessor)
    }

    /// An attribute of the used vertices; nothing where the primitive has none of that name.
    fn vectors<const N: usize>(
        &self,
        name: &str,
        count: usize,
        used: &Used,
    ) -> Result<Vec<[f64; N]>> {
        let Some(&accessor) = self.primitive.attributes.get(name) else {
            return Ok(Vec::new());
        };
        let all = self.attribute::<N>((name, accessor), count)?;
        Ok(used.pick(&all).collect())
    }

    fn texture_coordinates(&self, set: usize, count: usize, used: &Used) -> Result<Vec<[f32; 2]>> {
        let all = self.vectors::<2>(&format!("TEXCOORD_{set}"), count, used)?;
        Ok(all.into_iter().map(|uv| uv.map(|c| c as f32)).collect())
    }

    /// The first set of vertex colours; opaque where it says no opacity.
    fn colours(&self, count: usize, used: &Used) -> Result<Vec<[f32; 4]>> {
        const NAME: &str = "COLOR_0";
        let accessor = self.primitive.attributes.get(NAME);
        let accessor = accessor.and_then(|&a| self.file.document.accessors.get(a));
        let all: Vec<[f64; 4]> = match accessor.map(|a| a.kind.as_str()) {
            Some("VEC4") => self.vectors(NAME, count, used)?,
            Some("VEC3") => (self.vectors::<3>(NAME, count, used)?.into_iter())
                .map(|[r, g, b]| [r, g, b, 1.0])
                .collect(),
            _ => Vec::new(),
        };
        let colour = |c: [f64; 4]| c.map(|c| c.clamp(0.0, 1.0) as f32);
        Ok(all.into_iter().map(colour).collect())
    }

    /// Scalars of attributes whose names begin with an underscore, and the channels of vertex colours: `_SOFT` is the
    /// map `soft`, the red of `COLOR_0` is `color_0.r`.
    fn painted(&self, count: usize, used: &Used) -> Result<BTreeMap<String, Vec<f64>>> {
        let mut painted = BTreeMap::new();
        for (name, &accessor) in &self.primitive.attributes {
            let found = self.file.document.accessors.get(accessor);
            let kind = found.map_or("", |a| a.kind.as_str());
            let own = name.strip_prefix('_').filter(|n| !n.is_empty());
            match own {
                Some(own) if kind == "SCALAR" => {
                    let all = self.attribute::<1>((name, accessor), count)?;
                    let values = used.pick(&all).map(|[v]| v).collect();
                    painted.insert(own.to_lowercase(), values);
                }
                None if name.starts_with("COLOR_") && kind == "VEC3" => {
                    let all = self.attribute::<3>((name, accessor), count)?;
                    painted.extend(channels(name, &all, used));
                }
                None if name.starts_with("COLOR_") && kind == "VEC4" => {
                    let all = self.attribute::<4>((name, accessor), count)?;
                    painted.extend(channels(name, &all, used));
                }
                _ => {}
            }
        }
        Ok(painted)
    }

    /// Joints and weights of all sets together, and how many vertices had none.
    fn influences(
        &self,
        skin: usize,
        count: usize,
        used: &Used,
    ) -> Result<(Rows<(u32, f64)>, usize)> {
        let joints = match self.file.document.skins.get(skin) {
            Some(found) if found.joints.is_empty() => {
                return Err(
                    self.broken(format!("skin {skin} has no joints: bind the mesh to bones"))
                );
            }
            Some(found) => found.joints.len(),
            None => return Err(self.broken(format!("skin {skin} is not there"))),
        };
        let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); used.vertices.len()];
        for set in 0..MOST_SETS {
            let names = [format!("JOINTS_{set}"), format!("WEIGHTS_{set}")];
            let accessors = names.each_ref().map(|n| self.primitive.attributes.get(n));
            let [Some(&bones), Some(&weights)] = accessors else {
                break;
            };
            let bones = self.attribute::<4>((&names[0], bones), count)?;
            let weights = self.attribute::<4>((&names[1], weights), count)?;
            let all = used.pick(&bones).zip(used.pick(&weights));
            for ((v, row), (bones, weights)) in rows.iter_mut().enumerate().zip(all) {
                for (bone, weight) in bones.into_iter().zip(weights) {
                    if weight == 0.0 {
                        continue;
                    }
                    let v = used.vertices[v];
                    if weight < 0.0 {
                        let problem = format!("vertex {v}: weight {weight} must not be negative");
                        return Err(self.broken(problem));
                    }
                    if !(bone >= 0.0 && bone < joints as f64 && bone.fract() == 0.0) {
                        let problem = format!("vertex {v} names joint {bone} of {joints}");
                        return Err(self.broken(problem));
                    }
                    match row.iter_mut().find(|(b, _)| *b == bone as u32) {
                        Some((_, w)) => *w += weight,
                        None => row.push((bone as u32, weight)),
                    }
                }
            }
        }
        let mut unweighted = 0;
        for row in &mut rows {
            let sum: f64 = row.iter().map(|(_, w)| w).sum();
            if row.is_empty() {
                unweighted += 1;
                row.push((0, 1.0));
            } else {
                row.iter_mut().for_each(|(_, w)| *w /= sum);
            }
        }
        Ok((rows.into_iter().collect(), unweighted))
    }

    fn morphs(&self, node: &Node, mesh: &Mesh, count: usize, used: &Used) -> Result<Vec<Morph>> {
        // Not of the standard, but of every tool; VRM 0.x has the names in the primitive.
        let extras = [&mesh.extras, &self.primitive.extras];
        let mut extras = extras.into_iter().flatten();
        let names = extras.find_map(|e| e.get("targetNames"));
        let name = |k: usize| names.and_then(|n| n.get(k)).and_then(Value::as_str);
        let defaults = node.weights.as_ref().or(mesh.weights.as_ref());
        let mut morphs = Vec::new();
        for (k, target) in self.primitive.targets.iter().enumerate() {
            let moves = match target.get("POSITION") {
                None => Vec::new(),
                Some(&accessor) => {
                    let all = self.attribute::<3>(("a target's POSITION", accessor), count)?;
                    let moves = (0..).zip(used.pick(&all).map(DVec3::from_array));
                    moves.filter(|(_, d)| *d != DVec3::ZERO).collect()
                }
            };
            morphs.push(Morph {
                name: name(k).map_or_else(|| format!("morph_{k}"), Into::into),
                default: defaults.and_then(|d| d.get(k)).copied().unwrap_or(0.0),
                moves,
            });
        }
        Ok(morphs)
    }
}

/// A map for each channel of a vertex colour.
fn channels<const N: usize>(
    name: &str,
    colours: &[[f64; N]],
    used: &Used,
) -> Vec<(String, Vec<f64>)> {
    let of = |(channel, letter): (usize, char)| {
        let values = used.pick(colours).map(|c| c[channel]).collect();
        (format!("{}.{letter}", name.to_lowercase()), values)
    };
    (0..N).zip(['r', 'g', 'b', 'a']).map(of).collect()
}
