//! Sections of Gmsh's version 2.2.

use super::gmsh::Gmsh;
use glam::DVec3;
use supple::Result;

/// Most tags of an element.
const MOST_TAGS: i64 = 1024;

pub(super) fn nodes(gmsh: &mut Gmsh) -> Result<()> {
    let count: u64 = gmsh.words.value("the number of nodes")?;
    if gmsh.words.binary {
        gmsh.words.end_line();
    }
    for _ in 0..count {
        let id = gmsh.int("a node's number")?;
        let [x, y, z] = [(); 3].map(|()| gmsh.real("a node's x, y, z"));
        if !gmsh.draft.node(id as u64, DVec3::new(x?, y?, z?)) {
            return Err(gmsh.words.fault(format!("node {id} stands twice")));
        }
    }
    Ok(())
}

/// Text: number, type, tags, nodes of each. Binary: type, count, tags of a block before its elements.
pub(super) fn elements(gmsh: &mut Gmsh) -> Result<()> {
    let count: u64 = gmsh.words.value("the number of elements")?;
    let binary = gmsh.words.binary;
    if binary {
        gmsh.words.end_line();
    }
    let mut read = 0;
    while read < count {
        if !binary {
            gmsh.int("an element's number")?;
        }
        let kind = gmsh.int("an element's type")? as u64;
        let of_block = if binary { gmsh.int("a count")? } else { 1 };
        let tags = gmsh.int("a number of tags")?;
        if of_block < 1 || of_block as u64 > count - read || !(0..=MOST_TAGS).contains(&tags) {
            return Err(gmsh
                .words
                .fault("a block of elements is not what its counts say"));
        }
        let corners = gmsh.node_count(kind)?;
        for _ in 0..of_block {
            if binary {
                gmsh.int("an element's number")?;
            }
            element(gmsh, kind, tags, corners)?;
        }
        read += of_block as u64;
    }
    Ok(())
}

/// Tags, of which the first two are the physical group and the entity, then nodes.
fn element(gmsh: &mut Gmsh, kind: u64, tags: i64, corners: usize) -> Result<()> {
    let mut first = [0; 2];
    for k in 0..tags as usize {
        let tag = gmsh.int("an element's tag")?;
        if let Some(place) = first.get_mut(k) {
            *place = tag;
        }
    }
    let mut nodes = [0; 9];
    for node in &mut nodes[..corners] {
        *node = gmsh.int("an element's node")? as u64;
    }
    let label = gmsh.label(kind, first[0], first[1]);
    gmsh.element(kind, &nodes[..corners], label);
    Ok(())
}
