//! Triangles out of indices, and the vertices that they use.

/// The triangles of a list, strip or fan; nothing for points and lines.
pub(super) fn assemble(indices: &[u32], mode: u32) -> Option<Vec<[u32; 3]>> {
    Some(match mode {
        4 => indices.as_chunks().0.to_vec(),
        // Every other triangle of a strip is wound the other way round.
        5 => (indices.windows(3).enumerate())
            .map(|(i, t)| match i % 2 {
                0 => [t[0], t[1], t[2]],
                _ => [t[1], t[0], t[2]],
            })
            .collect(),
        6 => (indices.iter().skip(1).zip(indices.iter().skip(2)))
            .map(|(b, c)| [indices[0], *b, *c])
            .collect(),
        _ => return None,
    })
}

/// The vertices that triangles use.
pub(super) struct Used {
    /// In the primitive, rising.
    pub vertices: Vec<u32>,
    /// Number among the used ones, of each that is used.
    number: Vec<u32>,
}

impl Used {
    pub fn new(count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut number = vec![u32::MAX; count];
        triangles
            .iter()
            .flatten()
            .for_each(|&v| number[v as usize] = 0);
        let mut vertices = Vec::new();
        for (v, number) in number.iter_mut().enumerate().filter(|(_, n)| **n == 0) {
            *number = vertices.len() as u32;
            vertices.push(v as u32);
        }
        Self { vertices, number }
    }

    /// Those of `all` that belong to used vertices.
    pub fn pick<'a, T: Copy>(&'a self, all: &'a [T]) -> impl Iterator<Item = T> + 'a {
        self.vertices.iter().map(|&v| all[v as usize])
    }

    /// Triangles of used vertices by their new numbers.
    pub fn renumber(&self, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let number = |v: u32| self.number[v as usize];
        triangles.iter().map(|t| t.map(number)).collect()
    }
}
