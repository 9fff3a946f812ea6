//! The published evaluation, written out in plain arrays: what the readers and the model are measured against.
//!
//! Loper et al. 2015, equations (2)–(9), with 4 × 4 matrices and the rotation matrix of Rodrigues' formula.

use crate::npy::{encode_f64, encode_u32};
use crate::pickle::writer::{Python, int, tuple};
use std::io::{Cursor, Write};
use supple::internal::math::Random;

/// A model as its file's arrays hold it; `[v][axis][k]` one after another.
pub(super) struct Published {
    pub vertices: usize,
    pub parents: Vec<u32>,
    pub ids: Vec<u32>,
    pub template: Vec<f64>,
    pub shapes: usize,
    pub shapedirs: Vec<f64>,
    pub posedirs: Vec<f64>,
    pub weights: Vec<f64>,
    pub regressor: Vec<f64>,
    /// Key, shape, numbers.
    pub hands: Vec<(&'static str, Vec<usize>, Vec<f64>)>,
}

type Matrix = [[f64; 4]; 4];

impl Published {
    /// A random model of so many bones, vertices and shape columns.
    pub fn random(bones: usize, vertices: usize, shapes: usize, random: &mut Random) -> Self {
        let mut numbers = |count: usize, size: f64| -> Vec<f64> {
            (0..count).map(|_| random.uniform(-size, size)).collect()
        };
        let template = numbers(3 * vertices, 1.0);
        let shapedirs = numbers(3 * vertices * shapes, 0.1);
        let posedirs = numbers(3 * vertices * 9 * (bones - 1), 0.1);
        let mut shares = |rows: usize, columns: usize| -> Vec<f64> {
            let mut all = numbers(rows * columns, 1.0);
            for row in all.chunks_exact_mut(columns) {
                // Half of the entries are 0, one never is.
                row.iter_mut().for_each(|w| *w = w.max(0.0));
                row[0] += 0.1;
                let sum: f64 = row.iter().sum();
                row.iter_mut().for_each(|w| *w /= sum);
            }
            all
        };
        let weights = shares(vertices, bones);
        let regressor = shares(bones, vertices);
        let parent = |j: usize, random: &mut Random| match j {
            0 => u32::MAX,
            _ => random.index(j) as u32,
        };
        Self {
            vertices,
            parents: (0..bones).map(|j| parent(j, random)).collect(),
            ids: (0..bones as u32).collect(),
            template,
            shapes,
            shapedirs,
            posedirs,
            weights,
            regressor,
            hands: Vec::new(),
        }
    }

    pub fn bones(&self) -> usize {
        self.parents.len()
    }

    /// Skinned vertices of shape coefficients by column and rotation vectors by bone.
    pub fn evaluate(
        &self,
        columns: &[(usize, f64)],
        pose: &[[f64; 3]],
        shift: [f64; 3],
    ) -> Vec<[f64; 3]> {
        let (bones, features) = (self.bones(), 9 * (self.bones() - 1));
        // v_shaped = T + S β
        let mut shaped = self.template.clone();
        for (at, v) in shaped.iter_mut().enumerate() {
            *v += (columns.iter())
                .map(|(k, c)| c * self.shapedirs[at * self.shapes + k])
                .sum::<f64>();
        }
        // J = J_regressor v_shaped
        let joint = |j: usize, axis: usize| -> f64 {
            (0..self.vertices)
                .map(|v| self.regressor[j * self.vertices + v] * shaped[3 * v + axis])
                .sum()
        };
        let joints: Vec<[f64; 3]> = (0..bones).map(|j| [0, 1, 2].map(|a| joint(j, a))).collect();
        // v_posed = v_shaped + P (R(θ) − I)
        let rotations: Vec<[[f64; 3]; 3]> = pose.iter().map(rodrigues).collect();
        let mut feature = Vec::new();
        for rotation in &rotations[1..] {
            for (row, line) in rotation.iter().enumerate() {
                for (column, r) in line.iter().enumerate() {
                    feature.push(if row == column { r - 1.0 } else { *r });
                }
            }
        }
        let mut posed = shaped.clone();
        for (at, v) in posed.iter_mut().enumerate() {
            *v += (0..features)
                .map(|k| feature[k] * self.posedirs[at * features + k])
                .sum::<f64>();
        }
        // G_j = G_parent [R_j | J_j − J_parent], then A_j = G_j with J_j taken to the origin.
        let mut world: Vec<Option<Matrix>> = vec![None; bones];
        while world.contains(&None) {
            for j in 0..bones {
                let parent = self.ids.iter().position(|id| *id == self.parents[j]);
                let from = parent.map_or([0.0; 3], |p| joints[p]);
                let offset = [0, 1, 2].map(|a| joints[j][a] - from[a]);
                let local = affine(&rotations[j], offset);
                match parent {
                    None => world[j] = Some(local),
                    Some(p) => world[j] = world[p].map(|parent| product(&parent, &local)),
                }
            }
        }
        let skinning: Vec<Matrix> = (world.iter().flatten().zip(&joints))
            .map(|(g, joint)| {
                let mut a = *g;
                for row in &mut a[..3] {
                    row[3] -= (0..3).map(|c| row[c] * joint[c]).sum::<f64>();
                }
                a
            })
            .collect();
        let skinned = |v: usize, axis: usize| {
            let place = [posed[3 * v], posed[3 * v + 1], posed[3 * v + 2], 1.0];
            let weights = &self.weights[v * bones..(v + 1) * bones];
            let part =
                |(w, a): (&f64, &Matrix)| w * (0..4).map(|c| a[axis][c] * place[c]).sum::<f64>();
            weights.iter().zip(&skinning).map(part).sum::<f64>() + shift[axis]
        };
        (0..self.vertices)
            .map(|v| [0, 1, 2].map(|axis| skinned(v, axis)))
            .collect()
    }

    /// Keys, shapes and numbers of the f64 arrays.
    fn arrays(&self) -> Vec<(&'static str, Vec<usize>, &[f64])> {
        let (v, b) = (self.vertices, self.bones());
        let mut all = vec![
            ("v_template", vec![v, 3], &self.template[..]),
            ("shapedirs", vec![v, 3, self.shapes], &self.shapedirs),
            ("posedirs", vec![v, 3, 9 * (b - 1)], &self.posedirs),
            ("weights", vec![v, b], &self.weights),
            ("J_regressor", vec![b, v], &self.regressor),
        ];
        all.extend(self.hands.iter().map(|(k, s, n)| (*k, s.clone(), &n[..])));
        all
    }

    fn triangles(&self) -> Vec<u32> {
        (0..self.vertices as u32 - 2)
            .flat_map(|v| [v, v + 1, v + 2])
            .collect()
    }

    /// As an archive.
    pub fn npz(&self) -> Vec<u8> {
        let (triangles, bones) = (self.triangles(), self.bones());
        let tree = [&self.parents[..], &self.ids].concat();
        let mut members: Vec<_> = self
            .arrays()
            .iter()
            .map(|(k, s, n)| (*k, encode_f64(s, n)))
            .collect();
        members.push(("f", encode_u32(&[triangles.len() / 3, 3], &triangles)));
        members.push(("kintree_table", encode_u32(&[2, bones], &tree)));
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (key, bytes) in members {
            let options = zip::write::SimpleFileOptions::default();
            zip.start_file(format!("{key}.npy"), options).unwrap();
            zip.write_all(&bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    /// As a pickle: shapes as chumpy's array, the regressor in columns, pose directions with the first
    /// index fastest, the tree as signed integers.
    pub fn pickle(&self, python: Python) -> Vec<u8> {
        let bones = self.bones();
        let module = if python == Python::Two { "csc" } else { "_csc" };
        let mut entries: Vec<(&str, Vec<u8>)> = Vec::new();
        for (key, shape, numbers) in self.arrays() {
            let value = match key {
                "shapedirs" => {
                    let state = [("x", python.f64s(&shape, numbers)), ("_itr", b"N".to_vec())];
                    python.object("chumpy.ch", "Ch", &state)
                }
                "J_regressor" => {
                    let class = format!("scipy.sparse.{module}");
                    python.object(&class, "csc_matrix", &self.columns(python))
                }
                "posedirs" => {
                    let data: Vec<u8> = fortran(&shape, numbers)
                        .iter()
                        .flat_map(|n| n.to_be_bytes())
                        .collect();
                    python.array(">f8", &shape, true, &data)
                }
                _ => python.f64s(&shape, numbers),
            };
            entries.push((key, value));
        }
        let triangles = self.triangles();
        entries.push(("f", python.u32s(&[triangles.len() / 3, 3], &triangles)));
        let tree = [&self.parents[..], &self.ids].concat();
        let signed = tree
            .iter()
            .flat_map(|id| i64::from(*id as i32).to_le_bytes());
        let signed: Vec<u8> = signed.collect();
        entries.push((
            "kintree_table",
            python.array("<i8", &[2, bones], false, &signed),
        ));
        entries.push(("bs_type", python.text("lrotmin")));
        entries.push(("J", python.object("chumpy.ch_ops", "add", &[("a", int(1))])));
        python.program(&python.dict(&entries))
    }

    /// State of the regressor as SciPy's columns.
    fn columns(&self, python: Python) -> [(&'static str, Vec<u8>); 4] {
        let (mut data, mut indices, mut starts) = (Vec::new(), Vec::new(), vec![0]);
        for v in 0..self.vertices {
            for j in 0..self.bones() {
                let share = self.regressor[j * self.vertices + v];
                if share != 0.0 {
                    data.push(share);
                    indices.push(j as u32);
                }
            }
            starts.push(data.len() as u32);
        }
        [
            (
                "_shape",
                tuple(&[int(self.bones() as i32), int(self.vertices as i32)]),
            ),
            ("data", python.f64s(&[data.len()], &data)),
            ("indices", python.u32s(&[indices.len()], &indices)),
            ("indptr", python.u32s(&[starts.len()], &starts)),
        ]
    }
}

/// Numbers of an a × b × c array with the first index fastest.
fn fortran(shape: &[usize], numbers: &[f64]) -> Vec<f64> {
    let [a, b, c] = [shape[0], shape[1], shape[2]];
    let places = (0..c).flat_map(|k| (0..b).flat_map(move |j| (0..a).map(move |i| (i, j, k))));
    places
        .map(|(i, j, k)| numbers[(i * b + j) * c + k])
        .collect()
}

/// R = I + sin θ K + (1 − cos θ) K², K = [v/θ]×.
fn rodrigues(v: &[f64; 3]) -> [[f64; 3]; 3] {
    let angle = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z] = v.map(|c| c / angle.max(1e-300));
    let k = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let mut r = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            let squared: f64 = (0..3).map(|m| k[i][m] * k[m][j]).sum();
            let identity = if i == j { 1.0 } else { 0.0 };
            r[i][j] = identity + angle.sin() * k[i][j] + (1.0 - angle.cos()) * squared;
        }
    }
    r
}

fn affine(r: &[[f64; 3]; 3], t: [f64; 3]) -> Matrix {
    let row = |i: usize| [r[i][0], r[i][1], r[i][2], t[i]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |i: usize, j: usize| (0..4).map(|k| a[i][k] * b[k][j]).sum();
    [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| entry(i, j)))
}
