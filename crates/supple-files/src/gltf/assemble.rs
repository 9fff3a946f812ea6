//! From the parts that a scene shows to one welded body.

use super::animation::motions;
use super::appearance::appearance;
use super::character::{Character, Shape, Whole};
use super::container::File;
use super::motion_bones::MotionBones;
use super::nodes::{FARTHEST, Nodes};
use super::polar::stretch;
use super::primitive::{Part, read_parts};
use super::reference_part::ReferencePart;
use super::rig::Rig;
use super::springs::spring_bones;
use super::told_springs::ToldSprings;
use super::vrm::Vrm;
use crate::motion::MotionClip;
use crate::weld::{CUT_WEIGHTS, DRAWN_WEIGHTS, Vertices};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::sync::Arc;
use supple::Result;
use supple::model::{JointList, PoseBlend, RenderMesh, SkinWeight, SpringBones, Surface, UpAxis};
use supple_bake::{Body, LayerMesh};

/// What a file's scene shows.
pub(super) struct Scene<'a> {
    file: &'a File,
    nodes: Nodes,
    parts: Vec<Part>,
    /// Primitives without triangles.
    skipped: usize,
}

impl<'a> Scene<'a> {
    pub fn new(file: &'a File) -> Result<Self> {
        let nodes = Nodes::read(file)?;
        let (parts, skipped) = read_parts(file, &nodes)?;
        Ok(Self {
            file,
            nodes,
            parts,
            skipped,
        })
    }

    pub fn character(&self) -> Result<Character> {
        let rig = Rig::new(self.file, &self.nodes, &self.parts)?;
        let mut soup = Soup::default();
        for part in &self.parts {
            match rig.place(&self.nodes, part) {
                Some(placed) => soup.add(part, placed),
                None => soup.boneless.push(part.name.clone()),
            }
        }
        let broken = |problem: String| self.file.broken("meshes", problem);
        if soup.render_meshes.is_empty() {
            return Err(broken(
                "the scene shows no triangles that bones move".into(),
            ));
        }
        let mut notes = soup.notes(&rig, self.skipped);
        notes.extend(stretches(&self.nodes, &rig));
        let stem = self.file.path.file_stem().unwrap_or_default();
        let joints = rig.joints(self.file, &self.nodes, &self.parts)?;
        let mut whole = soup.weld(&stem.to_string_lossy(), &rig, joints);
        if whole.body.skin.triangles.is_empty() {
            return Err(broken(
                "all triangles are flat where the file shows them at rest".into(),
            ));
        }
        let positions = &whole.body.skin.positions;
        // Comparisons with NaN are false.
        let near = |p: &DVec3| p.length_squared() < FARTHEST * FARTHEST;
        if let Some(v) = positions.iter().position(|p| !near(p)) {
            return Err(broken(format!("skin vertex {v} is out of all bounds")));
        }
        let vrm = Vrm::read(self.file, &rig);
        if vrm.ignored > 0 {
            let text = "names of VRM's humanoid are of no bone and were left out";
            notes.push(format!("{} {text}", vrm.ignored));
        }
        let springs = ToldSprings::read(self.file, &self.nodes);
        let (springs, about) = spring_bones(&springs, &self.nodes, &rig);
        notes.extend(about);
        whole.body.springs = springs;
        whole.body.skeleton.aliases = vrm.humanoid;
        let used = self.parts.iter().filter_map(|part| part.material_index);
        let (appearance, lost) = appearance(self.file, used);
        whole.body.appearance = Arc::new(appearance);
        notes.extend(lost);
        Ok(Character {
            whole,
            rest: rig.rest,
            faces: if vrm.is_0 { DVec3::NEG_Z } else { DVec3::Z },
            notes,
        })
    }

    pub fn motions(&self) -> Result<Vec<MotionClip>> {
        let rig = match self.parts.is_empty() {
            true => None,
            false => Some(Rig::new(self.file, &self.nodes, &self.parts)?),
        };
        let bones = MotionBones::new(self.file, &self.nodes, rig.as_ref())?;
        motions(self.file, &self.nodes, &bones)
    }
}

/// Bones that are not as large at rest, or not alike along their axes.
fn stretches(nodes: &Nodes, rig: &Rig) -> Vec<String> {
    /// Relative to the bone's scale.
    const TOLERANCE: f64 = 1e-3;
    let (mut stretched, mut flat, mut most) = (0, 0, 0.0);
    for &n in &rig.nodes {
        match stretch(nodes.rest_world[n].matrix3) {
            Some(by) if by > TOLERANCE => {
                stretched += 1;
                most = f64::max(most, by);
            }
            Some(_) => {}
            None => flat += 1,
        }
    }
    let mut notes = Vec::new();
    if stretched > 0 {
        let most = 100.0 * most;
        notes.push(format!(
            "{stretched} bones are stretched along an axis at rest, by {most:.1} % at most: the skin has that in its shape, \
             bones are rigid"
        ));
    }
    if flat > 0 {
        notes.push(format!(
            "{flat} bones are scaled to nothing at rest, and what hangs on them with them"
        ));
    }
    notes
}

/// All parts' vertices in one list, not yet welded.
#[derive(Default)]
struct Soup {
    positions: Vec<DVec3>,
    skinning: Vec<Vec<SkinWeight>>,
    /// Shapes that move each vertex.
    moves: Vec<Vec<(u32, DVec3)>>,
    /// Names and defaults of the shapes; a name that meshes share is one shape.
    shapes: Vec<(String, f64)>,
    painted: BTreeMap<String, Vec<f64>>,
    /// Its vertices number this list.
    render_meshes: Vec<RenderMesh>,
    /// Parts that no bone moves.
    boneless: Vec<String>,
    cancelled: usize,
    unweighted: usize,
}

impl Soup {
    fn add(&mut self, part: &Part, placed: ReferencePart) {
        let first = self.positions.len();
        let tangents = placed.tangents(&part.tangents);
        let normals = placed.normals(&part.normals);
        let flip = |[a, b, c]: [u32; 3]| {
            if placed.mirrored {
                [a, c, b]
            } else {
                [a, b, c]
            }
        };
        self.positions.extend(placed.positions);
        self.skinning.extend(placed.skinning);
        self.moves.resize(self.positions.len(), Vec::new());
        self.cancelled += placed.cancelled;
        self.unweighted += part.unweighted;
        let mut seen = BTreeSet::new();
        for morph in &part.morphs {
            // Two targets of one mesh that share a name stay two.
            let free = |(k, s): (usize, &(String, f64))| s.0 == morph.name && !seen.contains(&k);
            let known = self.shapes.iter().enumerate().position(free);
            let shape = known.unwrap_or_else(|| {
                self.shapes.push((morph.name.clone(), morph.default));
                self.shapes.len() - 1
            });
            seen.insert(shape);
            for &(v, d) in &morph.moves {
                let d = placed.linear[v as usize] * d;
                self.moves[first + v as usize].push((shape as u32, d));
            }
        }
        for v in &mut self.moves[first..] {
            v.sort_by_key(|m| m.0);
        }
        for (name, values) in &part.painted {
            let all = self.painted.entry(name.clone()).or_default();
            all.resize(first, 0.0);
            all.extend(values);
        }
        self.render_meshes.push(RenderMesh {
            name: part.name.clone(),
            material: part.material.clone(),
            vertices: (first as u32..self.positions.len() as u32).collect(),
            texture_coordinates: part.texture_coordinates.clone(),
            further_coordinates: part.further_coordinates.clone(),
            colours: part.colours.clone(),
            normals,
            material_index: part.material_index,
            tangents,
            triangles: part.triangles.iter().copied().map(flip).collect(),
        });
    }

    fn notes(&self, rig: &Rig, skipped: usize) -> Vec<String> {
        let mut notes = Vec::new();
        let mut note = |count: usize, text: &str| {
            if count > 0 {
                notes.push(format!("{count} {text}"));
            }
        };
        note(skipped, "primitives without triangles were left out");
        note(
            self.unweighted,
            "vertices without weights move with their skin's first joint",
        );
        let text = "vertices lie where the bind pose has them: at rest their bones turn against each other";
        note(self.cancelled, text);
        match rig.nodes.len() {
            _ if !rig.largest_first.is_empty() => {}
            1 => notes.push("the file has no skin: all of it is one rigid bone".into()),
            n => notes.push(format!(
                "the file has no skin: its {n} nodes that show or move something are bones, and what each shows is rigid"
            )),
        }
        if !self.boneless.is_empty() {
            let names = self.boneless.join(", ");
            notes.push(format!("left out, since no bone moves it: {names}"));
        }
        notes
    }

    /// One body: welded as files split it, then along cuts.
    fn weld(mut self, name: &str, rig: &Rig, joints: JointList) -> Whole {
        let vertices = Vertices {
            positions: &self.positions,
            skinning: &self.skinning,
            shapes: &self.moves,
        };
        let drawn = vertices.same(DRAWN_WEIGHTS, |_| true);
        let rims = rim_vertices(&self.triangles(&drawn), drawn.len());
        let cuts = vertices.same(CUT_WEIGHTS, |v| rims[v]);
        // Skin vertices are those that are the same as none before, for the physics; copies are those
        // that are so only where they are drawn.
        let (mut skin, mut copies) = (Vec::new(), Vec::new());
        let mut number = vec![0; drawn.len()];
        for v in (0..drawn.len()).filter(|&v| drawn[v] == v as u32) {
            let list = if cuts[v] == v as u32 {
                &mut skin
            } else {
                &mut copies
            };
            number[v] = list.len() as u32;
            list.push(v);
        }
        let physical: Vec<u32> = drawn.iter().map(|&v| cuts[v as usize]).collect();
        let triangles = self.triangles(&physical);
        for v in self
            .render_meshes
            .iter_mut()
            .flat_map(|part| &mut part.vertices)
        {
            let first = drawn[*v as usize] as usize;
            let copy = cuts[first] as usize != first;
            *v = number[first] + if copy { skin.len() as u32 } else { 0 };
        }
        let mut shapes: Vec<Shape> = (self.shapes.into_iter())
            .map(|(name, default)| Shape {
                name,
                default,
                moves: Vec::new(),
            })
            .collect();
        for (n, &v) in skin.iter().enumerate() {
            for &(shape, d) in &self.moves[v] {
                shapes[shape as usize].moves.push((n as u32, d));
            }
        }
        for values in self.painted.values_mut() {
            values.resize(drawn.len(), 0.0);
            *values = skin.iter().map(|&v| values[v]).collect();
        }
        let body = Body {
            name: name.into(),
            skeleton: rig.skeleton.clone(),
            joints,
            springs: SpringBones::default(),
            up: UpAxis::Y,
            skin: Surface {
                positions: skin.iter().map(|&v| self.positions[v]).collect(),
                triangles: (triangles.iter())
                    .map(|t| t.map(|v| number[v as usize]))
                    .collect(),
            },
            skinning: skin.iter().map(|&v| self.skinning[v].clone()).collect(),
            pose_blend: PoseBlend::default(),
            bone_surfaces: Vec::new(),
            layer: LayerMesh::default(),
            painted: self.painted,
            attachments: Vec::new(),
            render_meshes: self.render_meshes,
            appearance: Arc::default(),
        };
        let copies = (copies.into_iter())
            .map(|v| (number[cuts[v] as usize], self.skinning[v].clone()))
            .collect();
        Whole {
            body,
            copies,
            shapes,
        }
    }

    /// All triangles of the vertices that `first` makes of each, once each, without flat ones.
    fn triangles(&self, first: &[u32]) -> Vec<[u32; 3]> {
        let mut seen = BTreeSet::new();
        let all = self.render_meshes.iter().flat_map(|part| {
            let vertex = |v: u32| first[part.vertices[v as usize] as usize];
            part.triangles.iter().map(move |t| t.map(vertex))
        });
        all.filter(|&[a, b, c]| {
            let turned = [[a, b, c], [b, c, a], [c, a, b]];
            a != b && b != c && c != a && seen.insert(turned.into_iter().min())
        })
        .collect()
    }
}

/// Which vertices lie on an edge that is not matched by an opposite one.
fn rim_vertices(triangles: &[[u32; 3]], count: usize) -> Vec<bool> {
    let edges = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let all: HashSet<[u32; 2]> = triangles.iter().flat_map(edges).collect();
    let mut rims = vec![false; count];
    for [a, b] in triangles.iter().flat_map(edges) {
        if !all.contains(&[b, a]) {
            rims[a as usize] = true;
            rims[b as usize] = true;
        }
    }
    rims
}
