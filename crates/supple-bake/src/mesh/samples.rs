//! The solid as samples: a regular grid finer than the lattice, each sample in one lattice tet, with
//! the links between neighbours that stay inside.

use super::bcc::BccLattice;
use super::disjoint_sets::DisjointSets;
use super::scanlines::Grid;
use glam::DVec3;
use supple::model::Surface;

/// Where samples lie in their cell of 1/per_cell: no two coordinates of a sample, measured from the
/// centre of a cell, are then equal in size, so that no sample lies on the border of two tets.
const OFFSET: DVec3 = DVec3::new(1.0 / 6.0, 0.5, 0.7);

/// Flag of a sample inside the skin. The flags 2, 4 and 8 say that the way to the next sample along
/// x, y and z stays inside.
const SOLID: u8 = 1;

/// A sample inside with all three ways inside.
const ALL_FLAGS: u8 = 15;

/// No bone holds the sample.
const NO_BONE: u16 = u16::MAX;

/// Samples of a solid over a lattice; a sample's index is i + n_x (j + n_y k).
pub(super) struct Samples {
    /// Where they are.
    pub grid: Grid,
    flags: Vec<u8>,
    bone: Vec<u16>,
    per_cell: usize,
    /// For each place in a cell, the tet as seen from that cell.
    pattern: Vec<u32>,
    reference_cell: u32,
    lattice: BccLattice,
}

impl Samples {
    /// Samples `skin` and `bones`, `per_cell` along the edge of a cell.
    pub fn new(lattice: &BccLattice, per_cell: usize, skin: &Surface, bones: &[Surface]) -> Self {
        let spacing = lattice.cell / per_cell as f64;
        let grid = Grid {
            origin: lattice.origin + spacing * OFFSET,
            spacing,
            counts: lattice.counts.map(|n| n * per_cell),
        };
        let [nx, ny, nz] = grid.counts;
        let mut flags = vec![0; nx * ny * nz];
        let mut bone = vec![NO_BONE; nx * ny * nz];
        for axis in 0..3 {
            let runs = grid.inside_runs(skin, axis);
            let link = 2 << axis;
            for (line, runs) in runs.iter().enumerate() {
                let (first, stride) = grid.line(axis, line);
                for &(from, to) in runs {
                    let at = |i: u32| first + stride * i as usize;
                    (from..to).for_each(|i| flags[at(i)] |= link);
                    if axis == 0 {
                        (from..=to).for_each(|i| flags[at(i)] |= SOLID);
                    }
                }
            }
        }
        for (b, surface) in bones.iter().enumerate() {
            for (line, runs) in grid.inside_runs(surface, 0).iter().enumerate() {
                for &(from, to) in runs {
                    let samples = nx * line + from as usize..=nx * line + to as usize;
                    (bone[samples].iter_mut())
                        .filter(|held| **held == NO_BONE)
                        .for_each(|held| *held = b as u16);
                }
            }
        }
        let at = |i: usize, shift: f64| (i as f64 + shift) / per_cell as f64 - 0.5;
        let cell = [1; 3];
        let pattern = (0..per_cell.pow(3))
            .map(|s| {
                let [i, j, k] = [s % per_cell, s / per_cell % per_cell, s / per_cell.pow(2)];
                lattice.tet_at(cell, [at(i, OFFSET.x), at(j, OFFSET.y), at(k, OFFSET.z)])
            })
            .collect();
        Self {
            grid,
            flags,
            bone,
            per_cell,
            pattern,
            reference_cell: 12 * (1 + lattice.counts[0] * (1 + lattice.counts[1])) as u32,
            lattice: *lattice,
        }
    }

    /// Number of samples, inside or not.
    pub fn len(&self) -> usize {
        self.flags.len()
    }

    /// Whether sample `s` is inside the skin.
    pub fn is_solid(&self, s: usize) -> bool {
        self.flags[s] & SOLID != 0
    }

    /// The bone that holds sample `s`.
    pub fn bone(&self, s: usize) -> Option<u16> {
        (self.bone[s] != NO_BONE).then_some(self.bone[s])
    }

    /// Place of sample `s`, m.
    pub fn position(&self, s: usize) -> DVec3 {
        let [i, j, k] = self.grid.split(s);
        self.grid.origin + self.grid.spacing * DVec3::new(i as f64, j as f64, k as f64)
    }

    /// The solid samples within two steps of `place` along each axis, the nearest first.
    pub fn around(&self, place: DVec3) -> Vec<usize> {
        let steps = 1.999 * self.grid.spacing;
        self.nearest_first(self.in_box(place - steps, place + steps, |_| true), place)
    }

    /// The solid samples of `tet`, the nearest to `place` first.
    pub fn in_tet(&self, tet: u32, place: DVec3) -> Vec<usize> {
        let nodes = (self.lattice.tet_nodes(tet)).map(|n| self.lattice.node_position(n));
        let low = nodes.into_iter().fold(DVec3::INFINITY, DVec3::min);
        let high = nodes.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max);
        self.nearest_first(self.in_box(low, high, |s| self.tet(s) == tet), place)
    }

    /// The parts of the solid in the neighbourhood of `node`: its tets, grown by a sample so
    /// that what joins them by less than one counts. Each solid sample with its part's first one.
    pub fn parts_around(&self, node: u32) -> Vec<(usize, usize)> {
        let (place, reach) = (
            self.lattice.node_position(node),
            self.lattice.cell + self.grid.spacing,
        );
        // The tets around a node fill a rhombic dodecahedron.
        let near = |s: usize| {
            let d = (self.position(s) - place).abs();
            d.element_sum() - d.min_element() <= reach
        };
        let samples = self.in_box(place - reach, place + reach, near);
        let mut parts = DisjointSets::new(samples.len());
        for (i, &s) in samples.iter().enumerate() {
            for next in (0..3).filter_map(|axis| self.linked(s, axis)) {
                if let Ok(j) = samples.binary_search(&next) {
                    parts.union(i as u32, j as u32);
                }
            }
        }
        (samples.iter().enumerate())
            .map(|(i, &s)| (s, samples[parts.find(i as u32) as usize]))
            .collect()
    }

    /// The solid samples in a box that `keep` wants, in order.
    fn in_box(&self, low: DVec3, high: DVec3, keep: impl Fn(usize) -> bool) -> Vec<usize> {
        let [nx, ny, _] = self.grid.counts;
        let first = ((low - self.grid.origin) / self.grid.spacing)
            .ceil()
            .to_array();
        let last = ((high - self.grid.origin) / self.grid.spacing)
            .floor()
            .to_array();
        // A number below 0 becomes 0.
        let range = |a: usize| first[a] as usize..(last[a] as usize + 1).min(self.grid.counts[a]);
        let mut found = Vec::new();
        for k in range(2) {
            for j in range(1) {
                let row = range(0).map(|i| i + nx * (j + ny * k));
                found.extend(row.filter(|&s| self.is_solid(s) && keep(s)));
            }
        }
        found
    }

    fn nearest_first(&self, mut samples: Vec<usize>, place: DVec3) -> Vec<usize> {
        samples.sort_by_cached_key(|&s| {
            // Squares are not negative: their bits sort as they do.
            ((self.position(s) - place).length_squared().to_bits(), s)
        });
        samples
    }

    /// The lattice tet that holds sample `s`.
    pub fn tet(&self, s: usize) -> u32 {
        let n = self.per_cell;
        let [i, j, k] = self.grid.split(s);
        let [cells_x, cells_y, _] = self.lattice.counts;
        let cell = i / n + cells_x * (j / n + cells_y * (k / n));
        // Wrapping: cell 0 lies before the reference cell.
        (12 * cell as u32)
            .wrapping_sub(self.reference_cell)
            .wrapping_add(self.pattern[i % n + n * (j % n + n * (k % n))])
    }

    /// How many samples a tet of each of the twelve kinds holds.
    pub fn per_tet(&self) -> [u32; 12] {
        let mut count = [0; 12];
        // A tet's two halves lie in two cells, but all cells are alike.
        self.pattern
            .iter()
            .for_each(|tet| count[*tet as usize % 12] += 1);
        count
    }

    /// The next sample along `axis`, if the way there stays inside.
    pub fn linked(&self, s: usize, axis: usize) -> Option<usize> {
        let stride = [
            1,
            self.grid.counts[0],
            self.grid.counts[0] * self.grid.counts[1],
        ][axis];
        let link = SOLID | 2 << axis;
        let next = s + stride;
        (self.flags[s] & link == link && next < self.len() && self.is_solid(next)).then_some(next)
    }

    /// Calls `visit` with every solid sample.
    pub fn for_each_solid(&self, mut visit: impl FnMut(usize)) {
        (0..self.len())
            .filter(|&s| self.is_solid(s))
            .for_each(&mut visit);
    }

    /// Joins samples of one tet that are linked within a block of 2 × 2 × 2. The way between them may
    /// leave the tet, not the solid, and by less than the block.
    pub fn join_within_tets(&self, sets: &mut DisjointSets) {
        let [nx, ny, nz] = self.grid.counts;
        let steps: [usize; 8] =
            std::array::from_fn(|c| (c & 1) + nx * ((c >> 1 & 1) + ny * (c >> 2)));
        let n = self.per_cell;
        // Inside, where all of a block is linked, the joins repeat from cell to cell.
        let all_linked: Vec<Vec<(usize, usize)>> = (0..n.pow(3))
            .map(|s| {
                let first = (s % n + n) + nx * ((s / n % n + n) + ny * (s / n.pow(2) + n));
                twins(&[0; 8], &steps.map(|step| self.tet(first + step)))
            })
            .collect();
        for k in 0..nz - 1 {
            for j in 0..ny - 1 {
                let row = nx * (j + ny * k);
                let pattern = n * (j % n + n * (k % n));
                for i in 0..nx - 1 {
                    let first = row + i;
                    let corner = steps.map(|step| first + step);
                    if corner.iter().all(|&s| self.flags[s] == ALL_FLAGS) {
                        for &(c, d) in &all_linked[pattern + i % n] {
                            sets.union(corner[c] as u32, corner[d] as u32);
                        }
                    } else if corner.iter().filter(|&&s| self.is_solid(s)).count() > 1 {
                        let mut label = [0, 1, 2, 3, 4, 5, 6, 7];
                        for (c, axis) in BLOCK_EDGES {
                            if self.linked(corner[c], axis).is_some() {
                                let (a, b) = (label[c], label[c | 1 << axis]);
                                label.iter_mut().filter(|l| **l == b).for_each(|l| *l = a);
                            }
                        }
                        for (c, d) in twins(&label, &corner.map(|s| self.tet(s))) {
                            sets.union(corner[c] as u32, corner[d] as u32);
                        }
                    }
                }
            }
        }
    }
}

/// The edges of a block of 2 × 2 × 2 samples as (corner, axis); the corner bits are x 1, y 2, z 4.
const BLOCK_EDGES: [(usize, usize); 12] = [
    (0, 0),
    (2, 0),
    (4, 0),
    (6, 0),
    (0, 1),
    (1, 1),
    (4, 1),
    (5, 1),
    (0, 2),
    (1, 2),
    (2, 2),
    (3, 2),
];

/// Corners of a block that share label and tet, each with the one before it.
fn twins(label: &[usize; 8], tets: &[u32; 8]) -> Vec<(usize, usize)> {
    (1..8)
        .filter_map(|c| {
            let before = (0..c)
                .rev()
                .find(|&d| label[d] == label[c] && tets[d] == tets[c]);
            before.map(|d| (c, d))
        })
        .collect()
}

impl Grid {
    /// First sample and stride of a line of [`Grid::inside_runs`].
    fn line(&self, axis: usize, line: usize) -> (usize, usize) {
        let [nx, ny, nz] = self.counts;
        match axis {
            0 => (nx * line, 1),
            1 => (nx * ny * (line % nz) + line / nz, nx),
            _ => (line % nx + nx * (line / nx), nx * ny),
        }
    }

    /// The i, j, k of sample `s`.
    pub fn split(&self, s: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        [s % nx, s / nx % ny, s / (nx * ny)]
    }
}
