//! Vertices and triangles of the meshes that a scene shows (glTF 2.0, §3.7).

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
    /// Unit vectors and signs, or none at all.
    pub tangents: Vec<[f64; 4]>,
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
            let reader = Reader {
                file,
                field: format!("meshes[{m}].primitives[{p}]"),
                primitive,
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
        let positions = self.file.vectors::<3>(position)?;
        let count = positions.len();
        let indices = match self.primitive.indices {
            Some(accessor) => self.file.indices(accessor, count)?,
            None => (0..count as u32).collect(),
        };
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
        let names = self.file.document.materials.as_slice();
        let material = self.primitive.material.and_then(|m| names.get(m));
        Ok(Some(Part {
            name: (mesh.name.as_ref().or(node.name.as_ref()))
                .map_or_else(|| format!("mesh_{n}"), Clone::clone),
            material_index: (self.primitive.material)
                .filter(|_| material.is_some())
                .map(|m| m as u32),
            material: material.and_then(|m| m.name.clone()).unwrap_or_default(),
            node: n,
            skin: node.skin,
            positions: used.pick(&positions).map(DVec3::from_array).collect(),
            influences,
            texture_coordinates: self.texture_coordinates(count, &used)?,
            tangents: self.tangents(count, &used)?,
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
        // Before anything is read: a sparse accessor's count costs nothing in the file.
        if let Some(found) = found.filter(|a| a.count != count as u64) {
            let problem = format!("{name} has {} elements for {count} vertices", found.count);
            return Err(self.broken(problem));
        }
        self.file.vectors(accessor)
    }

    fn texture_coordinates(&self, count: usize, used: &Used) -> Result<Vec<[f32; 2]>> {
        const NAME: &str = "TEXCOORD_0";
        let Some(&accessor) = self.primitive.attributes.get(NAME) else {
            return Ok(Vec::new());
        };
        let all = self.attribute::<2>((NAME, accessor), count)?;
        Ok(used.pick(&all).map(|uv| uv.map(|c| c as f32)).collect())
    }

    fn tangents(&self, count: usize, used: &Used) -> Result<Vec<[f64; 4]>> {
        const NAME: &str = "TANGENT";
        let Some(&accessor) = self.primitive.attributes.get(NAME) else {
            return Ok(Vec::new());
        };
        let all = self.attribute::<4>((NAME, accessor), count)?;
        Ok(used.pick(&all).collect())
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
