//! A labelled tet mesh → the soft layer around bones.

use super::embed::embed;
use super::{SKIN, TetFile};
use std::collections::{BTreeMap, BTreeSet};
use supple::internal::math::Rows;
use supple::model::{Surface, TetMesh};
use supple::{Error, Result};
use supple_bake::{Body, LayerMesh};

/// The tissue of a [`TetFile`], its skin and what it says of the bones.
#[derive(Clone, Debug, PartialEq)]
pub struct TetLayer {
    /// The tissue's tets; its skin is [`TetLayer::skin`].
    pub layer: LayerMesh,
    /// The part of the tets' surface that is skin.
    pub skin: Surface,
    /// Closed surface of each bone whose tets or whose hollow the file holds; empty for the others.
    pub bone_surfaces: Vec<Surface>,
}

impl TetFile {
    /// The soft layer around `bones`. A label marks the bone that it is called like, or that `regions`, a
    /// table of labels and bones, gives it.
    ///
    /// # Errors
    /// [`Error::Invalid`] where `regions` names a label or bone that is not there, where no bone holds a
    /// node or a piece of the tissue, or nothing is tissue or skin; it tells the file's labels.
    pub fn layer(&self, bones: &[String], regions: &BTreeMap<String, String>) -> Result<TetLayer> {
        let bone_of_label = self.bones_of_labels(bones, regions)?;
        let bone = |label: u32| bone_of_label[label as usize];
        let bone_of_tet: Vec<_> = self.tet_labels.iter().map(|l| l.and_then(bone)).collect();
        let marked = self.marks.iter().filter_map(|&(n, l)| Some((n, bone(l)?)));
        self.layer_held(bones.len(), &bone_of_tet, marked)
    }

    /// Replaces the layer of `body` by this mesh: its skin is embedded, and the bones' surfaces, where
    /// the file has some, become the body's.
    ///
    /// # Errors
    /// Those of [`TetFile::layer`], and [`Error::Invalid`] where the skin does not fit the mesh.
    pub fn put_into(&self, body: &mut Body, regions: &BTreeMap<String, String>) -> Result<()> {
        let made = self.layer(&body.skeleton.names, regions)?;
        let mut layer = made.layer;
        layer.skin_embedding = embed(&layer.mesh, &body.skin.positions)?;
        body.layer = layer;
        if made.bone_surfaces.iter().any(|s| !s.triangles.is_empty()) {
            body.bone_surfaces = made.bone_surfaces;
        }
        Ok(())
    }

    /// The bone that each label marks.
    fn bones_of_labels(
        &self,
        bones: &[String],
        regions: &BTreeMap<String, String>,
    ) -> Result<Vec<Option<u32>>> {
        let find = |name: &str| bones.iter().position(|b| b == name).map(|b| b as u32);
        if let Some(label) = regions.keys().find(|label| !self.labels.contains(label)) {
            let problem = format!("the mesh has no label {label:?}; {}", self.told_labels());
            return Err(Error::invalid("regions", problem));
        }
        if let Some(bone) = regions.values().find(|bone| find(bone).is_none()) {
            let problem = format!("there is no bone {bone:?}; there are {}", bones.join(", "));
            return Err(Error::invalid("regions", problem));
        }
        let named = |label: &String| find(regions.get(label).unwrap_or(label));
        Ok(self.labels.iter().map(named).collect())
    }

    fn told_labels(&self) -> String {
        match self.labels.is_empty() {
            true => "it labels nothing".into(),
            false => format!("its labels are {}", self.labels.join(", ")),
        }
    }

    /// The layer of the tets that are no bone's, held by the bones' tets and by `marked` nodes.
    pub(super) fn layer_held(
        &self,
        bones: usize,
        bone_of_tet: &[Option<u32>],
        marked: impl Iterator<Item = (u32, u32)>,
    ) -> Result<TetLayer> {
        let mut held: Vec<Option<u32>> = vec![None; self.mesh.nodes.len()];
        // Where several bones meet, the first holds the node.
        let mut hold = |node: u32, bone: u32| {
            let holder = &mut held[node as usize];
            *holder = Some(holder.map_or(bone, |b| b.min(bone)));
        };
        for (tet, bone) in self.mesh.tets.iter().zip(bone_of_tet) {
            if let Some(bone) = bone {
                tet.iter().for_each(|&node| hold(node, *bone));
            }
        }
        let mut on_marked = vec![false; self.mesh.nodes.len()];
        for (node, bone) in marked {
            hold(node, bone);
            on_marked[node as usize] = true;
        }
        let skin = self.skin_triangles(bone_of_tet, &on_marked)?;
        let bone_surfaces = (0..bones as u32)
            .map(|bone| self.bone_surface(bone, bone_of_tet, &held, &skin))
            .collect();
        let tissue = (0..bone_of_tet.len()).filter(|&t| bone_of_tet[t].is_none());
        let tissue: Vec<[u32; 4]> = tissue.map(|t| self.mesh.tets[t]).collect();
        if tissue.is_empty() {
            return Err(Error::invalid(
                "regions",
                "every tet is bone: leave some for the tissue",
            ));
        }
        let nodes: Vec<u32> = sorted_nodes(tissue.iter().flatten());
        let new = |n: &u32| nodes.binary_search(n).unwrap_or(0) as u32;
        let skin_nodes: Vec<u32> = sorted_nodes(skin.iter().flatten());
        let place = |n: &u32| self.mesh.nodes[*n as usize];
        let layer = LayerMesh {
            tissue_fraction: vec![1.0; tissue.len()],
            bone_of_node: nodes.iter().map(|&n| held[n as usize]).collect(),
            skin_embedding: skin_nodes
                .iter()
                .map(|n| [(new(n), 1.0)])
                .collect::<Rows<_>>(),
            mesh: TetMesh {
                nodes: nodes.iter().map(place).collect(),
                tets: tissue
                    .iter()
                    .map(|tet| [0, 1, 2, 3].map(|i| new(&tet[i])))
                    .collect(),
            },
        };
        self.check_held(&layer)?;
        Ok(TetLayer {
            layer,
            skin: self.surface(&skin),
            bone_surfaces,
        })
    }

    /// Faces of the tissue that are skin: those whose nodes are all labelled so, or, where there is no
    /// such label, all of the outside that is no bone's.
    fn skin_triangles(
        &self,
        bone_of_tet: &[Option<u32>],
        on_marked: &[bool],
    ) -> Result<Vec<[u32; 3]>> {
        let label = self.labels.iter().position(|l| l == SKIN);
        let mut labelled = vec![false; self.mesh.nodes.len()];
        for (node, l) in &self.marks {
            labelled[*node as usize] |= Some(*l as usize) == label;
        }
        let is_labelled = labelled.contains(&true);
        let all = |face: &[u32; 3], nodes: &[bool]| face.iter().all(|n| nodes[*n as usize]);
        let tissue: BTreeSet<[u32; 3]> = (0..bone_of_tet.len())
            .filter(|&t| bone_of_tet[t].is_none())
            .flat_map(|t| self.mesh.faces(t).map(sorted))
            .collect();
        let mut outside = self.mesh.boundary_triangles();
        outside.retain(|face| {
            let skin = if is_labelled {
                all(face, &labelled)
            } else {
                !all(face, on_marked)
            };
            skin && tissue.contains(&sorted(*face))
        });
        match outside.is_empty() {
            true => Err(Error::invalid(
                "skin",
                "no outer face of the tissue is skin",
            )),
            false => Ok(outside),
        }
    }

    /// The outside of a bone's tets, or else the wall of its hollow; empty if it is not closed.
    fn bone_surface(
        &self,
        bone: u32,
        bone_of_tet: &[Option<u32>],
        held: &[Option<u32>],
        skin: &[[u32; 3]],
    ) -> Surface {
        let own = (0..bone_of_tet.len()).filter(|&t| bone_of_tet[t] == Some(bone));
        let tets: Vec<_> = own.map(|t| self.mesh.tets[t]).collect();
        let triangles = if tets.is_empty() {
            let skin: BTreeSet<_> = skin.iter().copied().collect();
            let wall = |face: &[u32; 3]| {
                !skin.contains(face) && face.iter().all(|n| held[*n as usize] == Some(bone))
            };
            let walls = self.mesh.boundary_triangles().into_iter().filter(wall);
            walls.map(|[a, b, c]| [a, c, b]).collect()
        } else {
            let nodes = self.mesh.nodes.clone();
            TetMesh { nodes, tets }.boundary_triangles()
        };
        let surface = self.surface(&triangles);
        if surface.is_closed() && surface.volume() > 0.0 {
            surface
        } else {
            Surface::default()
        }
    }

    /// The surface of `triangles`, its vertices in the order of the nodes.
    fn surface(&self, triangles: &[[u32; 3]]) -> Surface {
        let nodes = sorted_nodes(triangles.iter().flatten());
        let vertex = |n: u32| nodes.binary_search(&n).unwrap_or(0) as u32;
        Surface {
            positions: nodes.iter().map(|&n| self.mesh.nodes[n as usize]).collect(),
            triangles: triangles.iter().map(|t| t.map(vertex)).collect(),
        }
    }

    /// Every piece of the tissue must be held: nothing else would keep it.
    fn check_held(&self, layer: &LayerMesh) -> Result<()> {
        if layer.bone_of_node.iter().all(Option::is_none) {
            let problem = format!(
                "no label is a bone's name, so that nothing holds the tissue: give some of them bones, \
                 `regions = {{ \"label\" = \"bone\" }}`; {}",
                self.told_labels()
            );
            return Err(Error::invalid("regions", problem));
        }
        let pieces = super::bone::pieces(&layer.mesh);
        let holders = layer.bone_of_node.iter().zip(&pieces);
        let held: BTreeSet<u32> = holders
            .filter(|(b, _)| b.is_some())
            .map(|(_, p)| *p)
            .collect();
        match pieces.iter().find(|piece| !held.contains(piece)) {
            None => Ok(()),
            Some(piece) => {
                let nodes = pieces.iter().filter(|p| *p == piece).count();
                let place = layer.mesh.nodes[*piece as usize];
                let problem = format!(
                    "a piece of {nodes} nodes, at {place} m, is held by no bone: label its bone or remove it"
                );
                Err(Error::invalid("layer", problem))
            }
        }
    }
}

fn sorted(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}

fn sorted_nodes<'a>(nodes: impl Iterator<Item = &'a u32>) -> Vec<u32> {
    let mut nodes: Vec<u32> = nodes.copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
