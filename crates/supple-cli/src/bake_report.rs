//! A bake's figures as a table.

use super::terminal::print_table;
use supple_bake::{BakeReport, CubatureReport};

/// Millimetres, three of them as "least to greatest, median".
fn spread([least, median, greatest]: [f64; 3]) -> String {
    let mm = |m: f64| format!("{:.1}", 1e3 * m);
    format!(
        "{} to {} mm, median {}",
        mm(least),
        mm(greatest),
        mm(median)
    )
}

/// Litres, or millilitres of what is small.
fn volume(cubic_metres: f64) -> String {
    if cubic_metres < 1e-3 {
        format!("{:.1} ml", 1e6 * cubic_metres)
    } else {
        format!("{:.2} l", 1e3 * cubic_metres)
    }
}

fn mass(kg: f64) -> String {
    if kg < 1.0 {
        format!("{:.1} g", 1e3 * kg)
    } else {
        format!("{kg:.2} kg")
    }
}

/// "name value, …" of the bones that have any, the largest first.
fn by_bone<T: Copy + PartialOrd + Default>(
    names: &[String],
    values: &[T],
    text: impl Fn(T) -> String,
) -> String {
    const MOST: usize = 12;
    let mut bones: Vec<(&String, T)> = (names.iter().zip(values.iter().copied()))
        .filter(|(_, value)| *value > T::default())
        .collect();
    bones.sort_by(|a, b| b.1.partial_cmp(&a.1).unwrap_or(std::cmp::Ordering::Equal));
    let told = bones.iter().take(MOST);
    let mut parts: Vec<String> = told
        .map(|(name, v)| format!("{name} {}", text(*v)))
        .collect();
    if bones.len() > MOST {
        parts.push(format!("{} more", bones.len() - MOST));
    }
    parts.join(", ")
}

fn cubature(c: &CubatureReport) -> String {
    if c.all_tets {
        return format!("{} points: every tet", c.points);
    }
    let off = (c.weight_sum / c.volume - 1.0).abs();
    let negative = match (c.negative_weights, c.cells) {
        (0, true) => "each its cell's volume, none negative".into(),
        (0, false) => "none negative".into(),
        (n, false) => format!("{n} negative, each replaced by its cell's volume"),
        (n, true) => format!("{n} negative, all replaced by their cells' volumes"),
    };
    let [before, after] = c.stiffness_error.map(|e| 100.0 * e);
    format!(
        "{} points; weights sum to the tissue's volume within {off:.0e}; {negative}; handles' stiffness within \
         {after:.1} % ({before:.0} % before the weights were corrected for it)",
        c.points
    )
}

/// An attached part in words.
pub(super) fn attached(name: &str, vertices: usize, follows_tissue: bool) -> String {
    let followed = if follows_tissue {
        "the tissue"
    } else {
        "its bones"
    };
    format!("{name}: {vertices} vertices, follows {followed}")
}

/// Writes the table.
pub fn print_bake_report(r: &BakeReport) {
    let [x, y, z] = r.extent;
    let quality = &r.mesh.quality;
    let mut rows: Vec<(&str, String)> = vec![
        ("name", r.name.clone()),
        ("size", format!("{x:.3} × {y:.3} × {z:.3} m")),
        (
            "skin",
            format!(
                "{} vertices, {} triangles",
                r.skin_vertices, r.skin_triangles
            ),
        ),
    ];
    let found = r.mesh.skin.to_string();
    let plain = format!(
        "{} vertices, {} triangles",
        r.mesh.skin.vertices, r.mesh.skin.triangles
    );
    if r.mesh.skin.vertices > 0 && found != plain {
        rows.push((
            "found in the skin",
            found[plain.len().min(found.len())..]
                .trim_start_matches(", ")
                .into(),
        ));
    }
    for a in &r.attachments {
        rows.push(("attached", attached(&a.name, a.vertices, a.follows_tissue)));
    }
    if r.springs.joints > 0 {
        rows.push(("spring bones", r.springs.to_string()));
    }
    for note in &r.notes {
        rows.push(("note", note.clone()));
    }
    if !r.mesh.mesher.is_empty() {
        rows.push(("mesher", r.mesh.mesher.clone()));
    }
    rows.extend([
        (
            "soft layer",
            format!(
                "{} nodes ({} free), {} tets, {} inverted",
                quality.nodes, r.free_nodes, quality.tets, quality.inverted
            ),
        ),
        (
            "dihedral angles",
            format!(
                "{:.1}° to {:.1}°, median of each tet's smallest {:.1}°",
                quality.smallest_dihedral, quality.largest_dihedral, quality.median_dihedral
            ),
        ),
    ]);
    if r.mesh.thickness[2] > 0.0 {
        rows.push(("thickness", spread(r.mesh.thickness)));
    }
    let medians: Vec<f64> = r.depth_per_bone.iter().map(|d| d[1]).collect();
    let depth_on = by_bone(&r.bone_names, &medians, |d| format!("{:.1}", 1e3 * d));
    rows.push(("  median on, mm", depth_on));
    const MOST_PLACES: usize = 6;
    for place in r.thin_places.iter().take(MOST_PLACES) {
        rows.push(("warning", format!("thin: {place}")));
    }
    if r.thin_places.len() > MOST_PLACES {
        let more = r.thin_places.len() - MOST_PLACES;
        rows.push(("warning", format!("{more} more thin places, in --json")));
    }
    rows.push((
        "tissue",
        format!("{}, {}", volume(r.cubature.volume), mass(r.tissue_mass)),
    ));
    if r.mesh.skin_volume > 0.0 {
        rows.push((
            "inside the skin",
            format!(
                "{}, of which {} core",
                volume(r.mesh.skin_volume),
                volume(r.mesh.core_volume)
            ),
        ));
    }
    if r.mesh.bare_vertices > 0 {
        rows.push((
            "without tissue",
            format!("{} vertices follow their bones", r.mesh.bare_vertices),
        ));
    }
    rows.push((
        "bones",
        format!(
            "{}: {}, total with tissue {}{}",
            r.bone_names.len(),
            mass(r.bones.total),
            mass(r.bones.total + r.tissue_mass),
            match r.bones.raised {
                0 => String::new(),
                n => format!(" ({n} without mass got the least)"),
            }
        ),
    ));
    rows.push(("  mass of", by_bone(&r.bone_names, &r.bones.masses, mass)));
    let chosen = |chosen: bool| if chosen { " (chosen)" } else { "" };
    rows.push((
        "handles",
        format!(
            "{}{}, apart by {}",
            r.handles.count,
            chosen(r.handles.chosen),
            spread(r.handles.spacing)
        ),
    ));
    if r.handles.per_region.len() > 1 {
        let regions: Vec<String> = r.handles.per_region.iter().map(usize::to_string).collect();
        rows.push(("  of regions", regions.join(", ")));
    }
    rows.push((
        "  on",
        by_bone(&r.bone_names, &r.handles.per_bone, |n| n.to_string()),
    ));
    rows.extend([
        (
            "basis",
            format!(
                "misses affine functions by {:.0e}; truncation changes it by {:.1} %; {:.1} handles a vertex (at most {}), \
                 {:.1} a point (at most {})",
                r.basis.linear_precision,
                100.0 * r.basis.truncation_cost,
                r.basis.handles_per_vertex.0,
                r.basis.handles_per_vertex.1,
                r.basis.handles_per_point.0,
                r.basis.handles_per_point.1
            ),
        ),
        ("cubature", cubature(&r.cubature)),
        ("material", format!("{}{}", r.material, chosen(r.material_chosen))),
    ]);
    let softness: Vec<(String, String)> = (r.softness.iter())
        .map(|region| (format!("  {}", region.name), region.to_string()))
        .collect();
    rows.extend(
        softness
            .iter()
            .map(|(name, told)| (name.as_str(), told.clone())),
    );
    let [least, mean, greatest] = r.stiffness;
    if least != greatest {
        rows.push((
            "  stiffness",
            format!("× {least:.2} to {greatest:.2}, mean {mean:.2}"),
        ));
    }
    if r.basis.loose_tets > 0 {
        rows.push((
            "loose tets",
            format!(
                "{}: hang on the rest by an edge or a corner",
                r.basis.loose_tets
            ),
        ));
    }
    if !r.cost.seconds.is_empty() {
        let phases: Vec<String> = (r.cost.seconds.iter())
            .map(|(name, s)| format!("{name} {s:.2}"))
            .collect();
        rows.push((
            "seconds",
            format!("{:.1} ({})", r.cost.total_seconds(), phases.join(", ")),
        ));
    }
    if let Some(bytes) = r.cost.peak_memory {
        rows.push(("peak memory", format!("{:.0} MB", bytes as f64 / 1e6)));
    }
    print_table(rows);
}
