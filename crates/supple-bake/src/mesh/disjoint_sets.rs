//! Disjoint sets (union–find) whose representative is the smallest member, so that results do not
//! depend on the order of unions.

/// A partition of `0..count`.
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Every element alone.
    pub fn new(count: usize) -> Self {
        Self {
            parent: (0..count as u32).collect(),
        }
    }

    /// One more element, alone; its index.
    pub(crate) fn push(&mut self) -> u32 {
        let index = self.parent.len() as u32;
        self.parent.push(index);
        index
    }

    /// Number of elements.
    pub(crate) fn len(&self) -> usize {
        self.parent.len()
    }

    /// The smallest member of `x`'s set.
    pub fn find(&mut self, mut x: u32) -> u32 {
        while self.parent[x as usize] != x {
            let above = self.parent[self.parent[x as usize] as usize];
            self.parent[x as usize] = above;
            x = above;
        }
        x
    }

    /// Joins the sets of `a` and `b`.
    pub fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
