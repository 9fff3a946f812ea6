//! An editable closed triangle mesh: edge split, collapse and flip.
//!
//! It may be the half x ≥ 0 of a symmetric one. Its border on the plane x = 0, the seam, is then closed by a
//! fan of triangles to a vertex without a place, the apex, so that every edge has two triangles.

use glam::DVec3;
use std::collections::HashSet;

/// Vertices with the triangles around them; dead ones stay until [`EditMesh::compact`].
#[derive(Clone, Debug)]
pub(super) struct EditMesh {
    pub positions: Vec<DVec3>,
    triangles: Vec<Option<[u32; 3]>>,
    around: Vec<Vec<u32>>,
    live: usize,
    apex: Option<u32>,
    /// Whether each vertex lies on the seam.
    seam: Vec<bool>,
    live_on_seam: usize,
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
            seam: vec![false; positions.len()],
            positions,
            triangles: triangles.into_iter().map(Some).collect(),
            around,
            apex: None,
            live_on_seam: 0,
        }
    }

    /// Half of a symmetric surface, open along one loop on x = 0.
    pub fn half(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let apex = positions.len() as u32;
        let directed = |[a, b, c]: [u32; 3]| [(a, b), (b, c), (c, a)];
        let edges: HashSet<(u32, u32)> = triangles.iter().copied().flat_map(directed).collect();
        let border: Vec<(u32, u32)> = (triangles.iter().copied().flat_map(directed))
            .filter(|&(a, b)| !edges.contains(&(b, a)))
            .collect();
        let fan = border.iter().map(|&(a, b)| [b, a, apex]);
        let triangles = triangles.iter().copied().chain(fan).collect();
        let mut mesh = Self::new([positions, vec![DVec3::ZERO]].concat(), triangles);
        mesh.apex = Some(apex);
        mesh.live -= 1;
        for (a, _) in border {
            mesh.seam[a as usize] = true;
            mesh.positions[a as usize].x = 0.0;
            mesh.live_on_seam += 1;
        }
        mesh
    }

    /// Number of live vertices, of a half those of the whole surface.
    pub fn vertex_count(&self) -> usize {
        match self.apex {
            None => self.live,
            Some(_) => 2 * self.live - self.live_on_seam,
        }
    }

    pub fn is_half(&self) -> bool {
        self.apex.is_some()
    }

    /// How much [`EditMesh::vertex_count`] changes when the edge is split or collapsed.
    pub fn step(&self, a: u32, b: u32) -> usize {
        let doubled = self.apex.is_some() && !(self.on_seam(a) && self.on_seam(b));
        1 + usize::from(doubled)
    }

    pub fn is_live(&self, v: u32) -> bool {
        !self.around[v as usize].is_empty() && self.apex != Some(v)
    }

    pub fn on_seam(&self, v: u32) -> bool {
        self.seam[v as usize]
    }

    /// Whether the triangle is one of the surface and none of the apex's.
    fn is_real(&self, t: &[u32; 3]) -> bool {
        self.apex.is_none_or(|apex| !t.contains(&apex))
    }

    /// Live triangles.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let all = self.triangles.iter().flatten().copied();
        all.filter(|t| self.is_real(t))
    }

    /// Undirected edges, each once, in the triangles' order.
    pub fn edges(&self) -> Vec<(u32, u32)> {
        // With the apex's triangles every edge comes in both directions.
        let all = self.triangles.iter().flatten();
        let directed = all.flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let real = |v: u32| self.apex != Some(v);
        directed
            .filter(|&(a, b)| a < b && real(a) && real(b))
            .collect()
    }

    /// Live triangles around `v`, with the apex's.
    fn fan(&self, v: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.around[v as usize]
            .iter()
            .filter_map(|&t| self.triangles[t as usize])
    }

    /// Live triangles around `v`.
    pub fn triangles_around(&self, v: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.fan(v).filter(|t| self.is_real(t))
    }

    /// Neighbours of `v`.
    pub fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut all = self.ring(v);
        all.retain(|&n| self.apex != Some(n));
        all
    }

    /// Neighbours of `v`, with the apex: in a closed mesh each follows `v` in exactly one triangle.
    fn ring(&self, v: u32) -> Vec<u32> {
        self.fan(v)
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

    /// Number of neighbours in the whole surface.
    pub fn valence(&self, v: u32) -> usize {
        let around = self.around[v as usize].len();
        // On the seam two neighbours are their own mirror images; the apex is none.
        if self.on_seam(v) {
            2 * around - 4
        } else {
            around
        }
    }

    /// Whether one edge less would leave `v` too few.
    pub fn is_poor(&self, v: u32) -> bool {
        self.valence(v) <= if self.on_seam(v) { 4 } else { 3 }
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

    /// The vertices opposite to the edge in its two triangles; none of an edge of the seam.
    pub fn wing(&self, a: u32, b: u32) -> Option<(u32, u32)> {
        let (c, d) = (self.opposite(a, b)?.1, self.opposite(b, a)?.1);
        let real = self.apex.is_none_or(|apex| apex != c && apex != d);
        real.then_some((c, d))
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
        let on_seam = self.apex.is_some_and(|apex| apex == c || apex == d);
        self.positions.push(position);
        self.seam.push(on_seam);
        self.live += 1;
        if on_seam {
            self.positions[m as usize].x = 0.0;
            self.live_on_seam += 1;
        }
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

    /// Merges `b` into `a`, or `a` into `b` where that is on the seam, at `position` unless that would
    /// break the surface or turn a triangle by more than about 60°.
    pub fn collapse(&mut self, a: u32, b: u32, position: DVec3) -> bool {
        let (a, b) = if self.on_seam(b) { (b, a) } else { (a, b) };
        let (Some((t0, c)), Some((t1, d))) = (self.opposite(a, b), self.opposite(b, a)) else {
            return false;
        };
        // Link condition (Dey et al. 1999): the edge's ends share exactly the two wing vertices.
        let other = self.ring(b);
        let shared = self.ring(a).into_iter().filter(|v| other.contains(v));
        let poor = [c, d].map(|v| self.apex != Some(v) && self.is_poor(v));
        if shared.count() != 2 || poor != [false; 2] {
            return false;
        }
        // No edge between seam vertices but along the seam: its mirror image would be the same edge.
        let crosses = |n: &u32| *n != a && *n != c && *n != d && self.on_seam(*n);
        if self.on_seam(a) && !self.on_seam(b) && other.iter().any(crosses) {
            return false;
        }
        for v in [a, b] {
            for &t in &self.around[v as usize] {
                let Some(triangle) = self.triangles[t as usize] else {
                    continue;
                };
                if t == t0 || t == t1 || !self.is_real(&triangle) {
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
        if self.on_seam(a) {
            self.positions[a as usize].x = 0.0;
        }
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
        self.live_on_seam -= usize::from(self.on_seam(b));
        true
    }

    /// Replaces the edge by the other diagonal of its wing, if that keeps the surface and its sense.
    pub fn flip(&mut self, a: u32, b: u32) -> bool {
        let (Some((t0, c)), Some((t1, d))) = (self.opposite(a, b), self.opposite(b, a)) else {
            return false;
        };
        if c == d || self.ring(c).contains(&d) {
            return false;
        }
        let is_apex = |v: u32| self.apex == Some(v);
        if is_apex(c) || is_apex(d) || (self.on_seam(c) && self.on_seam(d)) {
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
            if self.is_live(v as u32) {
                *slot = positions.len() as u32;
                positions.push(self.positions[v]);
            }
        }
        let triangles = self
            .triangles()
            .map(|t| t.map(|v| index[v as usize]))
            .collect();
        (positions, triangles)
    }
}
