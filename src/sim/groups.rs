//! Which members one linear system moves.

/// That a frame of a member's state stands for a body: its own, and part of its member's gradient and Hessian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Link {
    /// The member that touches the body.
    pub member: usize,
    /// The frame of its state that stands for the body.
    pub frame: usize,
    /// The member that is the body.
    pub body: usize,
}

/// A partition of the members: what is in one group moves in one linear system.
#[derive(Clone, Debug, Default)]
pub(crate) struct Groups {
    /// Members, group after group, in each rising.
    members: Vec<usize>,
    /// Where each group ends in `members`.
    ends: Vec<usize>,
    /// Sorted by group, then by member and frame.
    links: Vec<Link>,
    /// Where each group's links end in `links`.
    link_ends: Vec<usize>,
    /// Memory of the partition: each member's first known one of its group.
    roots: Vec<usize>,
    /// Each member's group.
    group_of: Vec<usize>,
}

impl Groups {
    /// Every one of `count` members by itself.
    pub fn singles(count: usize) -> Self {
        let mut out = Self::default();
        out.set(count, &[]);
        out
    }

    /// `count` members of which `links` join some, in the memory of the partition before. Groups are in the order of
    /// their first members, so that the same links give the same sums whatever has been before.
    pub fn set(&mut self, count: usize, links: &[Link]) {
        self.roots.clear();
        self.roots.extend(0..count);
        for link in links {
            let (a, b) = (self.root(link.member), self.root(link.body));
            self.roots[a.max(b)] = a.min(b);
        }
        self.group_of.clear();
        self.ends.clear();
        for member in 0..count {
            let root = self.root(member);
            let group = if root == member {
                self.ends.push(0);
                self.ends.len() - 1
            } else {
                self.group_of[root]
            };
            self.group_of.push(group);
            self.ends[group] += 1;
        }
        // From how many there are to where they start, and, as they are filled in, to where they end.
        let mut start = 0;
        for end in &mut self.ends {
            start += std::mem::replace(end, start);
        }
        self.members.resize(count, 0);
        for (member, &group) in self.group_of.iter().enumerate() {
            self.members[self.ends[group]] = member;
            self.ends[group] += 1;
        }
        self.links.clear();
        self.links.extend(links);
        let group_of = &self.group_of;
        (self.links).sort_unstable_by_key(|l| (group_of[l.member], l.member, l.frame));
        let of_group = |g: usize| self.links.partition_point(|l| group_of[l.member] <= g);
        self.link_ends.clear();
        self.link_ends.extend((0..self.ends.len()).map(of_group));
    }

    /// The least member known to be in `member`'s group.
    fn root(&mut self, member: usize) -> usize {
        let mut root = member;
        while self.roots[root] != root {
            root = self.roots[root];
        }
        self.roots[member] = root;
        root
    }

    /// Number of groups.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Members of a group, rising.
    pub fn members(&self, group: usize) -> &[usize] {
        part(&self.members, &self.ends, group)
    }

    /// What joins the members of a group; empty where it has one member alone.
    pub fn links(&self, group: usize) -> &[Link] {
        part(&self.links, &self.link_ends, group)
    }

    /// The group that a member is in.
    pub fn of(&self, member: usize) -> usize {
        self.group_of[member]
    }

    /// Whether a member is the only one of its group.
    pub fn is_alone(&self, member: usize) -> bool {
        self.members(self.group_of[member]).len() == 1
    }

    /// Whether every member is by itself.
    pub fn is_single(&self) -> bool {
        self.links.is_empty()
    }
}

fn part<'a, T>(items: &'a [T], ends: &[usize], i: usize) -> &'a [T] {
    let start = if i == 0 { 0 } else { ends[i - 1] };
    &items[start..ends[i]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_that_share_a_body_are_one_group_in_fixed_order() {
        let link = |member, frame, body| Link {
            member,
            frame,
            body,
        };
        // 0 and 3 touch body 5, 3 also body 6; 1 touches body 4; 2 nothing.
        let links = [link(3, 9, 6), link(0, 7, 5), link(1, 7, 4), link(3, 8, 5)];
        let mut groups = Groups::singles(9);
        for _ in 0..2 {
            groups.set(7, &links);
            assert_eq!(groups.len(), 3);
            assert_eq!(groups.members(0), [0, 3, 5, 6]);
            assert_eq!(groups.members(1), [1, 4]);
            assert_eq!(groups.members(2), [2]);
            assert_eq!(groups.links(0), [links[1], links[3], links[0]]);
            assert!(groups.links(2).is_empty() && !groups.is_single());
        }
        let mut turned = links;
        turned.reverse();
        groups.set(7, &turned);
        assert_eq!(groups.links(0), [links[1], links[3], links[0]]);
        groups.set(2, &[]);
        assert!(groups.is_single() && groups.len() == 2 && groups.members(1) == [1]);
    }
}
