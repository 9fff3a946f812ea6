//! Sections of Gmsh's version 4.1: the same numbers in text and binary.

use super::gmsh::Gmsh;
use glam::DVec3;
use supple::Result;

/// Notes the first physical group of every point, curve, surface and volume.
pub(super) fn entities(gmsh: &mut Gmsh) -> Result<()> {
    begin(gmsh);
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = gmsh.size("a number of entities")?;
    }
    for (dimension, count) in (0u8..).zip(counts) {
        for _ in 0..count {
            let entity = gmsh.int("an entity's number")?;
            // A point's place, or the corners of a bounding box.
            for _ in 0..(if dimension == 0 { 3 } else { 6 }) {
                gmsh.real("an entity's place")?;
            }
            for k in 0..gmsh.size("a number of physical groups")? {
                let group = gmsh.int("a physical group")?;
                if k == 0 {
                    gmsh.groups.insert((dimension, entity), group);
                }
            }
            if dimension > 0 {
                for _ in 0..gmsh.size("a number of bounding entities")? {
                    gmsh.int("a bounding entity")?;
                }
            }
        }
    }
    Ok(())
}

/// Blocks: entity, numbers of its nodes, then their places.
pub(super) fn nodes(gmsh: &mut Gmsh) -> Result<()> {
    begin(gmsh);
    let blocks = header(gmsh)?;
    for _ in 0..blocks {
        let dimension = gmsh.int("an entity's dimension")?;
        gmsh.int("an entity's number")?;
        let parametric = gmsh.int("whether nodes are parametric")?;
        let count = gmsh.size("a number of nodes")?;
        // Each node takes a byte at least.
        if count > gmsh.words.left() as u64 {
            return Err(gmsh
                .words
                .fault(format!("{count} nodes are more than the file can hold")));
        }
        let mut ids = Vec::new();
        for _ in 0..count {
            ids.push(gmsh.size("a node's number")?);
        }
        for id in ids {
            let [x, y, z] = [(); 3].map(|()| gmsh.real("a node's x, y, z"));
            if !gmsh.draft.node(id, DVec3::new(x?, y?, z?)) {
                return Err(gmsh.words.fault(format!("node {id} stands twice")));
            }
            // Its coordinates on a curve or surface follow.
            for _ in 0..(if parametric == 1 {
                dimension.clamp(0, 3)
            } else {
                0
            }) {
                gmsh.real("a node's parameter")?;
            }
        }
    }
    Ok(())
}

/// Blocks of one type: entity, then each element's number and nodes.
pub(super) fn elements(gmsh: &mut Gmsh) -> Result<()> {
    begin(gmsh);
    let blocks = header(gmsh)?;
    for _ in 0..blocks {
        let dimension = gmsh.int("an entity's dimension")?;
        let entity = gmsh.int("an entity's number")?;
        let kind = gmsh.int("an element's type")? as u64;
        let count = gmsh.size("a number of elements")?;
        let corners = gmsh.node_count(kind)?;
        let key = u8::try_from(dimension).map(|d| (d, entity));
        let group = key.ok().and_then(|key| gmsh.groups.get(&key)).copied();
        let label = gmsh.label(kind, group.unwrap_or(0), entity);
        for _ in 0..count {
            gmsh.size("an element's number")?;
            let mut nodes = [0; 9];
            for node in &mut nodes[..corners] {
                *node = gmsh.size("an element's node")?;
            }
            gmsh.element(kind, &nodes[..corners], label);
        }
    }
    Ok(())
}

/// Number of blocks; the total, least and greatest number, which follow, are not needed.
fn header(gmsh: &mut Gmsh) -> Result<u64> {
    let blocks = gmsh.size("a number of blocks")?;
    for _ in 0..3 {
        gmsh.size("a total, least or greatest number")?;
    }
    Ok(blocks)
}

fn begin(gmsh: &mut Gmsh) {
    if gmsh.words.binary {
        gmsh.words.end_line();
    }
}
