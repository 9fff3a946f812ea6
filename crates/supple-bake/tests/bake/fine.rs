//! Fine handles: their columns, blocks, cells, and what a file makes of them.

use super::file::{seal, survives_forgery};
use super::{TINY, recipe};
use std::path::Path;
use std::sync::{Arc, LazyLock};
use supple::Error;
use supple::file::{AvatarFile, Parts};
use supple::glam::{DMat3, DVec3};
use supple::internal::math::Rows;
use supple::model::{Avatar, FineHandles};
use supple_bake::subspace::{Subspace, rest_stiffness};
use supple_bake::{
    BakeReport, CubatureRecipe, FineExtension, FineRecipe, HandleCandidates, Recipe, bake,
    from_bytes, to_bytes,
};

/// So few points that cells have children.
fn coarse() -> Recipe {
    Recipe {
        cubature: CubatureRecipe {
            points: Some(40),
            ..CubatureRecipe::default()
        },
        ..recipe(HandleCandidates::Skin, 8)
    }
}

fn asked(fine: FineRecipe) -> Recipe {
    Recipe {
        fine_handles: Some(fine),
        ..coarse()
    }
}

fn baked(fine: FineRecipe) -> (Avatar, BakeReport) {
    bake(&TINY.body().unwrap(), &asked(fine), &mut |_| {}).unwrap()
}

static FINE: LazyLock<(Avatar, BakeReport)> = LazyLock::new(|| baked(FineRecipe::default()));

/// Skin vertex at `place`.
fn vertex_at(avatar: &Avatar, place: DVec3) -> usize {
    let found = avatar.skin.position.iter().position(|p| *p == place);
    found.unwrap()
}

#[test]
fn there_are_none_unless_they_are_asked_for() {
    let (avatar, report) = bake(&TINY.body().unwrap(), &coarse(), &mut |_| {}).unwrap();
    assert!(avatar.fine.is_empty() && report.fine.is_none());
    let bytes = to_bytes(&avatar, None).unwrap();
    assert!(!bytes.windows(4).any(|tag| tag == b"fine"));
    // Whoever has them has the same coarse model.
    let fine = Avatar {
        fine: Arc::default(),
        ..FINE.0.clone()
    };
    assert_eq!(avatar, fine);
}

#[test]
fn a_column_is_1_at_its_handle_and_0_at_all_others() {
    let (avatar, report) = &*FINE;
    let fine = &avatar.fine;
    let report = report.fine.as_ref().unwrap();
    assert!(report.count == fine.len() && fine.len() >= avatar.handles.len());
    for (k, &place) in avatar.handles.iter().chain(&fine.positions).enumerate() {
        let own = k.checked_sub(avatar.handles.len());
        for &(h, u) in fine.skin.row(vertex_at(avatar, place)) {
            let expected = f32::from(u8::from(own == Some(h as usize)));
            assert!((u - expected).abs() < 1e-6, "U_{h} at {k}: {u}");
        }
    }
    for h in 0..fine.len() {
        let own = fine.skin.row(vertex_at(avatar, fine.positions[h]));
        assert!(own.iter().any(|u| u.0 as usize == h), "{h}");
    }
    // No soft skin is farther from a handle; all of this limb's is soft.
    for p in &avatar.skin.position {
        let handles = avatar.handles.iter().chain(&fine.positions);
        let nearest = handles
            .map(|h| h.distance(*p))
            .fold(f64::INFINITY, f64::min);
        assert!(nearest <= fine.spacing, "{nearest}");
    }
}

/// N of every node as a space's, by code that knows nothing of points.
fn space(avatar: &Avatar) -> Subspace {
    let fine = &avatar.fine;
    let block = |&(h, n): &(u32, [f32; 9])| (h, DMat3::from_cols_array(&n.map(f64::from)));
    Subspace::new(avatar, fine.positions.clone(), fine.nodes.map(block)).unwrap()
}

#[test]
fn blocks_of_points_are_those_of_their_tets() {
    let (avatar, _) = &*FINE;
    let fine = &avatar.fine;
    let mesh = &avatar.layer.mesh;
    let tets: Vec<u32> = (fine.corners.iter())
        .map(|corners| mesh.tets.iter().position(|tet| tet == corners).unwrap() as u32)
        .collect();
    let expected = space(avatar).at_tets(&tets);
    let (mut blocks, mut seen) = (Vec::new(), 0);
    for point in 0..tets.len() {
        fine.blocks(point, |_| true, &mut blocks);
        let expected = expected.row(point);
        assert_eq!(blocks.len(), expected.len());
        for (own, other) in blocks.iter().zip(expected) {
            assert_eq!(own.handle, other.handle);
            assert!(own.value.abs_diff_eq(other.value, 1e-14));
            for (own, other) in own.gradient.iter().zip(&other.gradient) {
                // The slopes are of f32.
                let size = other
                    .to_cols_array()
                    .iter()
                    .fold(1.0f64, |m, e| m.max(e.abs()));
                assert!(own.abs_diff_eq(*other, 4e-6 * size), "{own} {other}");
            }
            seen += 1;
        }
        // Of some handles alone.
        fine.blocks(point, |h| h % 2 == 0, &mut blocks);
        let even = expected.iter().filter(|b| b.handle % 2 == 0);
        assert!(blocks.iter().map(|b| b.handle).eq(even.map(|b| b.handle)));
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn below_the_skin_tissue_is_in_equilibrium_unless_blocks_are_dropped() {
    let exact = FineRecipe {
        drop_below: 0.0,
        ..FineRecipe::default()
    };
    let (avatar, _) = baked(exact);
    let space = space(&avatar);
    let stiffness = rest_stiffness(&avatar);
    let layer = &avatar.layer;
    let mut skin = vec![false; layer.mesh.nodes.len()];
    (layer.skin_embedding.entries().iter()).for_each(|e| skin[e.0 as usize] = true);
    let free: Vec<usize> = (0..skin.len())
        .filter(|&n| layer.bone_of_node[n].is_none())
        .collect();
    let forces_on = |h: usize, axis: usize| {
        let mut state = space.avatar().rest_state();
        state.handles[h][axis] = 1.0;
        let u = space.displacement(&state).unwrap();
        let free: Vec<f64> = free.iter().flat_map(|&n| u[n].to_array()).collect();
        stiffness.multiply(&free)
    };
    for h in [0, 3, avatar.fine.len() - 1] {
        let forces = forces_on(h, h % 3);
        let size = |f: &[f64]| f.iter().fold(0.0f64, |m, f| m.max(f.abs()));
        let inside = free.iter().enumerate().filter(|(_, n)| !skin[**n]);
        let rest = inside.map(|(k, _)| size(&forces[3 * k..3 * k + 3]));
        let rest = rest.fold(0.0, f64::max);
        assert!(
            rest < 1e-5 * size(&forces),
            "{h}: {rest} of {}",
            size(&forces)
        );
    }
    // Dropped blocks are the small ones, and most.
    let kept = |avatar: &Avatar| avatar.fine.nodes.entries().len();
    assert!(kept(&FINE.0) < kept(&avatar));
    let size = |n: &[f32; 9]| (n.iter().map(|e| e * e).sum::<f32>() / 3.0).sqrt();
    for (full, dropped) in avatar.fine.nodes.iter().zip(FINE.0.fine.nodes.iter()) {
        for (h, n) in full {
            let there = dropped.iter().find(|d| d.0 == *h);
            let found = there.map_or(0.0, |d| size(&d.1));
            let expected = if size(n) > 0.03 { size(n) } else { 0.0 };
            assert!((found - expected).abs() < 0.031, "{found} of {}", size(n));
            assert!(size(n) < 0.031 || (found - expected).abs() < 1e-6);
        }
    }
}

#[test]
fn two_levels_of_points_have_the_tissues_volume_and_nearly_its_middle() {
    let (avatar, _) = &*FINE;
    let fine = &avatar.fine;
    let tets = 0..avatar.layer.mesh.tets.len();
    let volume = |t: usize| avatar.layer.tissue_fraction[t] * avatar.layer.mesh.volume(t);
    let whole: f64 = tets.clone().map(volume).sum();
    let middle: DVec3 = tets
        .map(|t| volume(t) * avatar.layer.mesh.centroid(t))
        .sum();
    let points = avatar.cubature.position.iter().zip(&fine.own_measure);
    let children = fine.points.position.iter().zip(&fine.points.measure);
    let (mut sum, mut first) = (0.0, DVec3::ZERO);
    for (p, w) in points.chain(children) {
        sum += w;
        first += *w * *p;
    }
    assert!((sum / whole - 1.0).abs() < 1e-12);
    let off = (first / sum - middle / whole).length();
    assert!(off < 1e-3, "{off} m");
    // Children lie in cells that some handle wakes, and are found by their cell.
    let mut seen = 0;
    for cell in 0..avatar.cubature.len() {
        for child in fine.children(cell) {
            assert_eq!(fine.cell_of_point[child] as usize, cell);
            assert!(fine.cells.entries().contains(&(cell as u32)));
            seen += 1;
        }
    }
    assert!(seen > 50 && seen == fine.points.len(), "{seen}");
}

#[test]
fn the_biharmonic_form_is_a_number_times_the_identity_everywhere() {
    let (avatar, _) = baked(FineRecipe {
        extension: FineExtension::Biharmonic,
        ..FineRecipe::default()
    });
    let elastic = &FINE.0.fine;
    assert_eq!(avatar.fine.skin, elastic.skin);
    for (_, n) in avatar.fine.nodes.entries() {
        assert_eq!(*n, [n[0], 0.0, 0.0, 0.0, n[0], 0.0, 0.0, 0.0, n[0]]);
    }
    let off = |(_, n): &&(u32, [f32; 9])| n[1].abs() > 0.02;
    assert!(elastic.nodes.entries().iter().filter(off).count() > 10);
}

fn problem(avatar: &Avatar) -> String {
    to_bytes(avatar, None).unwrap_err().to_string()
}

#[test]
fn a_file_brings_them_back_and_one_of_before_has_none() {
    let (avatar, report) = &*FINE;
    let path = Path::new("limb.supple");
    let bytes = to_bytes(avatar, Some(report)).unwrap();
    let back = from_bytes(&bytes, path).unwrap();
    assert_eq!(back.avatar, *avatar);
    assert_eq!(back.report.unwrap().fine, report.fine);
    // What a step reads has them too.
    let step = AvatarFile::new(avatar.clone())
        .to_bytes(Parts::Step)
        .unwrap();
    let back = from_bytes(&step, path).unwrap().avatar;
    assert!(back.layer.is_empty() && back.fine == avatar.fine);
    // Points without their handles, or handles without points.
    for tag in [*b"fine", *b"fcub"] {
        let at = bytes.windows(4).position(|found| found == tag).unwrap();
        let mut renamed = bytes.clone();
        renamed[at] = b'x';
        seal(&mut renamed);
        match from_bytes(&renamed, path) {
            Ok(back) => assert!(tag == *b"fine" && back.avatar.fine.is_empty()),
            Err(error) => {
                assert!(matches!(error, Error::Format { .. }), "{error:?}");
                assert!(error.to_string().contains("fcub"), "{error}");
            }
        }
    }
}

#[test]
fn damaged_tables_are_named() {
    let broken = |change: fn(&mut FineHandles)| {
        let mut avatar = FINE.0.clone();
        change(Arc::make_mut(&mut avatar.fine));
        problem(&avatar)
    };
    let row = |row: &[(u32, f32)]| -> Rows<(u32, f32)> {
        let rows = FINE.0.fine.skin.iter().map(|r| r.to_vec());
        let mut rows: Vec<Vec<(u32, f32)>> = rows.collect();
        rows[0] = row.to_vec();
        rows.into_iter().collect()
    };
    assert!(broken(|f| f.spacing = 0.0).contains("fine.spacing"));
    assert!(broken(|f| f.positions[1].x = f64::NAN).contains("fine.positions"));
    assert!(broken(|f| f.positions.clear()).contains("fine"));
    assert!(broken(|f| f.own_measure[0] = 0.0).contains("fine.own_measure"));
    assert!(broken(|f| f.points.measure[0] = -1e-9).contains("fine.points.measure"));
    assert!(broken(|f| f.cell_of_point[0] = u32::MAX).contains("fine.cell_of_point"));
    assert!(broken(|f| f.cell_of_point.truncate(1)).contains("fine.cell_of_point"));
    assert!(broken(|f| f.tissue.truncate(1)).contains("fine.tissue"));
    assert!(broken(|f| f.corners[3][1] = u32::MAX).contains("fine.corners"));
    assert!(broken(|f| f.slopes[3][1][0] = f32::NAN).contains("fine.slopes"));
    assert!(broken(|f| f.cells = f.cells.map(|c| c + 9999)).contains("fine.cells"));
    assert!(broken(|f| f.nodes = f.nodes.map(|n| (n.0 + 9999, n.1))).contains("fine.nodes"));
    for wrong in [&[(0, f32::NAN)][..], &[(9999, 1.0)], &[(1, 0.5), (0, 0.5)]] {
        let mut avatar = FINE.0.clone();
        Arc::make_mut(&mut avatar.fine).skin = row(wrong);
        assert!(problem(&avatar).contains("fine.skin"), "{wrong:?}");
    }
}

#[test]
fn a_forged_checksum_does_not_get_nonsense_in() {
    let bytes = to_bytes(&FINE.0, None).unwrap();
    let first = bytes.windows(4).position(|tag| tag == b"fine").unwrap();
    survives_forgery(&bytes, first, 9, 600);
}

#[test]
fn what_cannot_be_made_is_an_error_that_names_the_key() {
    let error = |fine: FineRecipe| {
        let made = bake(&TINY.body().unwrap(), &asked(fine), &mut |_| {});
        made.unwrap_err().to_string()
    };
    let coarse = FineRecipe {
        spacing: Some(10.0),
        ..FineRecipe::default()
    };
    assert!(error(coarse).contains("recipe.fine_handles"));
    let negative = FineRecipe {
        spacing: Some(-1.0),
        ..FineRecipe::default()
    };
    assert!(error(negative).contains("recipe.fine_handles.spacing"));
}
