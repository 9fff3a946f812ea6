//! An editable closed triangle mesh: edge split, collapse and flip.

use glam::DVec3;

/// Vertices with the triangles around them; dead ones stay until [`EditMesh::compact`].
#[derive(Clone, Debug)]
pub(super) struct EditMesh {
    pub positions: Vec<DVec3>,
    triangles: Vec<Option<[u32; 3]>>,
    around: Vec<Vec<u32>>,
    live: usize,
}

impl EditMesh {
    pub fn new(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let mut around = vec![Vec::new(); positions.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            triangle
                .iter()
                .for_each(|&v| around[v as usize].push(t as u32));
        }
        Self {
            live: positions.len(),
            positions,
            triangles: triangles.into_iter().map(Some).collect(),
            around,
        }
    }

    /// Number of live vertices.
    pub fn vertex_count(&self) -> usize {
        self.live
    }

    pub fn is_live(&self, v: u32) -> bool {
        !self.around[v as usize].is_empty()
    }

    /// Live triangles.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.triangles.iter().flatten().copied()
    }

    /// Undirected edges, each once, in the triangles' order.
    pub fn edges(&self) -> Vec<(u32, u32)> {
        let directed = self
            .triangles()
            .flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]);
        directed.filter(|(a, b)| a < b).collect()
    }

    /// Live triangles around `v`.
    pub fn triangles_around(&self, v: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.around[v as usize]
            .iter()
            .filter_map(|&t| self.triangles[t as usize])
    }

    /// Neighbours of `v`: in a closed mesh each follows `v` in exactly one triangle.
    pub fn neighbours(&self, v: u32) -> Vec<u32> {
        self.triangles_around(v)
            .map(|[a, b, c]| {
                if a == v {
                    b
                } else if b == v {
                    c
                } else {
                    a
                }
            })
            .collect()
    }

    pub fn valence(&self, v: u32) -> usize {
        self.around[v as usize].len()
    }

    pub fn length(&self, a: u32, b: u32) -> f64 {
        self.positions[a as usize].distance(self.positions[b as usize])
    }

    /// Area vector of a triangle.
    pub fn area_vector(&self, t: [u32; 3]) -> DVec3 {
        let [a, b, c] = t.map(|v| self.positions[v as usize]);
        0.5 * (b - a).cross(c - a)
    }

    /// The triangle with the directed edge a → b, and the vertex opposite to it.
    fn opposite(&self, a: u32, b: u32) -> Option<(u32, u32)> {
        self.around[a as usize].iter().find_map(|&t| {
            let [i, j, k] = self.triangles[t as usize]?;
            [(i, j, k), (j, k, i), (k, i, j)]
                .into_iter()
                .find(|&(p, q, _)| p == a && q == b)
                .map(|(_, _, r)| (t, r))
        })
    }

    /// The vertices opposite to the edge in its two triangles.
    pub fn wing(&self, a: u32, b: u32) -> Option<(u32, u32)> {
        Some((self.opposite(a, b)?.1, self.opposite(b, a)?.1))
    }

    fn detach(&mut self, v: u32, t: u32) {
        self.around[v as usize].retain(|&x| x != t);
    }

    /// Puts `position` in the middle of the edge.
    pub fn split(&mut self, a: u32, b: u32, position: DVec3) {
        let (Some((t0, c)), Some((t1, d))) = (self.opposite(a, b), self.opposite(b, a)) else {
            return;
        };
        let m = self.positions.len() as u32;
        let (t2, t3) = (self.triangles.len() as u32, self.triangles.len() as u32 + 1);
        self.positions.push(position);
        self.live += 1;
        self.triangles[t0 as usize] = Some([a, m, c]);
        self.triangles[t1 as usize] = Some([m, a, d]);
        self.triangles.push(Some([m, b, c]));
        self.triangles.push(Some([b, m, d]));
        self.detach(b, t0);
        self.detach(b, t1);
        self.around[b as usize].extend([t2, t3]);
        self.around[c as usize].push(t2);
        self.around[d as usize].push(t3);
        self.around.push(vec![t0, t1, t2, t3]);
    }

    /// Merges `b` into `a` at `position` unless that would break the surface or turn a triangle by
    /// more than about 60°.
    pub fn collapse(&mut self, a: u32, b: u32, position: DVec3) -> bool {
        let (Some((t0, c)), Some((t1, d))) = (self.opposite(a, b), self.opposite(b, a)) else {
            return false;
        };
        // Link condition (Dey et al. 1999): the edge's ends share exactly the two wing vertices.
        let other = self.neighbours(b);
        let shared = self.neighbours(a).into_iter().filter(|v| other.contains(v));
        if shared.count() != 2 || self.valence(c) <= 3 || self.valence(d) <= 3 {
            return false;
        }
        for v in [a, b] {
            for &t in &self.around[v as usize] {
                let Some(triangle) = self.triangles[t as usize] else {
                    continue;
                };
                if t == t0 || t == t1 {
                    continue;
                }
                let moved = triangle.map(|w| {
                    if w == v {
                        position
                    } else {
                        self.positions[w as usize]
                    }
                });
                let before = self.area_vector(triangle);
                let after = 0.5 * (moved[1] - moved[0]).cross(moved[2] - moved[0]);
                if after.dot(before) <= 0.5 * after.length() * before.length() {
                    return false;
                }
            }
        }
        self.positions[a as usize] = position;
        for t in [t0, t1] {
            for v in self.triangles[t as usize].into_iter().flatten() {
                self.detach(v, t);
            }
            self.triangles[t as usize] = None;
        }
        for t in std::mem::take(&mut self.around[b as usize]) {
            if let Some(triangle) = &mut self.triangles[t as usize] {
                triangle
                    .iter_mut()
                    .filter(|v| **v == b)
                    .for_each(|v| *v = a);
            }
            self.around[a as usize].push(t);
        }
        self.live -= 1;
        true
    }

    /// Replaces the edge by the other diagonal of its wing, if that keeps the surface and its sense.
    pub fn flip(&mut self, a: u32, b: u32) -> bool {
        let (Some((t0, c)), Some((t1, d))) = (self.opposite(a, b), self.opposite(b, a)) else {
            return false;
        };
        if c == d || self.neighbours(c).contains(&d) {
            return false;
        }
        let (first, second) = ([c, a, d], [d, b, c]);
        let before = self.area_vector([a, b, c]) + self.area_vector([b, a, d]);
        for t in [first, second] {
            let area = self.area_vector(t);
            if area.dot(before) <= 0.7 * area.length() * before.length() {
                return false;
            }
        }
        self.triangles[t0 as usize] = Some(first);
        self.triangles[t1 as usize] = Some(second);
        self.detach(b, t0);
        self.detach(a, t1);
        self.around[d as usize].push(t0);
        self.around[c as usize].push(t1);
        true
    }

    /// Positions and triangles without the dead ones.
    pub fn compact(self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let mut index = vec![0u32; self.positions.len()];
        let mut positions = Vec::with_capacity(self.live);
        for (v, slot) in index.iter_mut().enumerate() {
            if !self.around[v].is_empty() {
                *slot = positions.len() as u32;
                positions.push(self.positions[v]);
            }
        }
        let triangles = self
            .triangles
            .iter()
            .flatten()
            .map(|t| t.map(|v| index[v as usize]))
            .collect();
        (positions, triangles)
    }
}
