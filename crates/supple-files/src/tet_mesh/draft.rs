//! A mesh as a file gives it, and what it must be to be read.

use super::TetFile;
use super::checks::{check_topology, is_place, orient, used_nodes};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use supple::model::TetMesh;
use supple::{Error, Result};

/// Most nodes or tets: their indices are 32 bits wide.
const MOST: usize = u32::MAX as usize / 4;

/// Nodes by the file's own numbers, tets and labelled surfaces over those numbers.
#[derive(Default)]
pub(super) struct Draft {
    nodes: Vec<DVec3>,
    ids: HashMap<u64, u32>,
    tets: Vec<([u64; 4], Option<u32>)>,
    /// Nodes of labelled surfaces.
    marks: Vec<(u64, u32)>,
    labels: Vec<String>,
    label_of_name: BTreeMap<String, u32>,
}

impl Draft {
    /// The index of the label called `name`.
    pub fn label(&mut self, name: &str) -> u32 {
        if let Some(&label) = self.label_of_name.get(name) {
            return label;
        }
        let label = self.labels.len() as u32;
        self.labels.push(name.to_string());
        self.label_of_name.insert(name.to_string(), label);
        label
    }

    /// Adds a node; false where there was one of that number.
    #[must_use]
    pub fn node(&mut self, id: u64, place: DVec3) -> bool {
        let index = self.nodes.len() as u32;
        self.nodes.push(place);
        self.ids.insert(id, index).is_none()
    }

    /// Adds a tet.
    pub fn tet(&mut self, nodes: [u64; 4], label: Option<u32>) {
        self.tets.push((nodes, label));
    }

    /// Marks a node of a labelled surface.
    pub fn mark(&mut self, node: u64, label: u32) {
        self.marks.push((node, label));
    }

    /// The mesh, checked: places finite, nodes there, tets whole and oriented; nodes of no tet are left out.
    pub fn finish(self, path: &Path) -> Result<TetFile> {
        let fault = |place: String, problem: &str| Error::format(path, place, problem);
        if self.tets.is_empty() {
            return Err(fault(
                "tets".into(),
                "there are none: mesh the volume, and save it",
            ));
        }
        if self.nodes.len().max(self.tets.len()) > MOST {
            return Err(fault(
                "size".into(),
                "is more than can be read: coarsen the mesh",
            ));
        }
        if let Some(n) = self.nodes.iter().position(|n| !is_place(*n)) {
            let problem = "is no place in metres: mend the coordinates";
            return Err(fault(format!("node {n}, counted from 0"), problem));
        }
        let mut mesh = TetMesh {
            nodes: self.nodes,
            tets: Vec::with_capacity(self.tets.len()),
        };
        for (t, (ids, _)) in self.tets.iter().enumerate() {
            let mut tet = [0; 4];
            for (node, id) in tet.iter_mut().zip(ids) {
                *node = *self.ids.get(id).ok_or_else(|| {
                    fault(of_tet(t), &format!("names node {id}, which is not there"))
                })?;
            }
            if (1..4).any(|i| tet[..i].contains(&tet[i])) {
                return Err(fault(of_tet(t), "needs four different nodes"));
            }
            mesh.tets.push(tet);
            orient(&mut mesh, t).map_err(|problem| fault(of_tet(t), problem))?;
        }
        check_topology(&mesh).map_err(|(t, problem)| fault(of_tet(t), &problem))?;
        let mut marks = Vec::with_capacity(self.marks.len());
        for (id, label) in self.marks {
            let node = self.ids.get(&id).ok_or_else(|| {
                let label = format!("surface {}", self.labels[label as usize]);
                fault(label, &format!("names node {id}, which is not there"))
            })?;
            marks.push((*node, label));
        }
        marks.sort_unstable();
        marks.dedup();
        let file = TetFile {
            mesh,
            labels: self.labels,
            tet_labels: self.tets.iter().map(|t| t.1).collect(),
            marks,
        };
        Ok(without_loose_nodes(file))
    }
}

fn of_tet(t: usize) -> String {
    format!("tet {t}, counted from 0")
}

fn without_loose_nodes(mut file: TetFile) -> TetFile {
    let used = used_nodes(&file.mesh);
    let mut kept = 0;
    let new: Vec<u32> = (used.iter())
        .map(|used| {
            kept += u32::from(*used);
            kept.wrapping_sub(1)
        })
        .collect();
    let mut keep = used.iter();
    file.mesh.nodes.retain(|_| keep.next() == Some(&true));
    file.mesh
        .tets
        .iter_mut()
        .flatten()
        .for_each(|n| *n = new[*n as usize]);
    file.marks.retain(|(n, _)| used[*n as usize]);
    file.marks
        .iter_mut()
        .for_each(|(n, _)| *n = new[*n as usize]);
    file
}
