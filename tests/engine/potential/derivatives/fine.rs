//! Fine handles that are awake: the same potential with more handles and more points.

use super::case::{Case, cases};
use super::{STEP, difference, evaluate, largest, unit};
use pollster::block_on;
use std::sync::Arc;
use supple::glam::{DMat3, DVec3};
use supple::internal::cpu::HessianForm;
use supple::internal::math::{Random, Rows};
use supple::internal::random_avatar;
use supple::model::{Avatar, Awake, FineHandles, State};
use supple::potential::{CpuPotential, Potential, PreviousSkin};

/// Fine handles, slots, and handles that are awake.
const FINE: usize = 5;
const SLOTS: usize = 3;
const AWAKE: [u32; 2] = [3, 1];

/// Random fine handles for `avatar`, whose layer is a cube of six tets on a bone.
fn fine(avatar: &Avatar) -> FineHandles {
    let random = &mut Random::new(31);
    let (coarse, mesh) = (avatar.cubature.len(), &avatar.layer.mesh);
    let mut points = random_avatar(32, avatar.bones(), avatar.handles.len(), 9, 60).cubature;
    points.pose_blend = Default::default();
    let tets: Vec<usize> = (0..coarse + points.len())
        .map(|_| random.index(6))
        .collect();
    let slopes = |t: &usize| {
        let [a, b, c, _] = mesh.barycentric_gradients(*t);
        [a, b, c].map(|g| g.as_vec3().to_array())
    };
    let block = |random: &mut Random| random.matrix(0.6).to_cols_array().map(|e| e as f32);
    let nodes: Rows<(u32, [f32; 9])> = (0..8)
        .map(|n| match n < 4 {
            true => Vec::new(),
            false => (0..FINE as u32).map(|h| (h, block(random))).collect(),
        })
        .collect();
    let vertices = avatar.tissue_vertices() + avatar.attached.len();
    let mut skin = |_| {
        let handles = random.subset(FINE, 2);
        let mut row: Vec<(u32, f32)> = handles
            .into_iter()
            .map(|h| (h as u32, random.uniform(0.1, 0.8) as f32))
            .collect();
        row.sort_by_key(|u| u.0);
        row
    };
    FineHandles {
        spacing: 0.01,
        skin: (0..vertices).map(&mut skin).collect(),
        nodes,
        cells: [vec![0, 1], vec![1, 2, 5], vec![4], vec![2, 7], vec![0]]
            .into_iter()
            .collect(),
        own_measure: avatar.cubature.measure.iter().map(|w| 0.4 * w).collect(),
        cell_of_point: vec![0, 1, 1, 2, 2, 4, 5, 7, 7],
        tissue: vec![avatar.tissue[1]; points.len()],
        corners: tets.iter().map(|&t| mesh.tets[t]).collect(),
        slopes: tets.iter().map(slopes).collect(),
        positions: vec![DVec3::ZERO; FINE],
        points,
        slots: 0,
    }
}

fn wake(awake: &mut Awake, avatar: &Avatar, handle: u32) -> bool {
    let coarse = avatar.coarse_handles();
    awake.wake(&avatar.fine, coarse, handle, std::iter::empty())
}

/// The case with slots, and handles awake in some of them, their cells two thirds of the way.
fn with_fine(mut case: Case) -> (Case, Awake) {
    case.avatar.fine = Arc::new(fine(&case.avatar));
    case.avatar.validate().unwrap();
    case.avatar = case.avatar.with_fine_slots(SLOTS).unwrap();
    let mut awake = Awake::none(&case.avatar);
    for handle in AWAKE {
        assert!(wake(&mut awake, &case.avatar, handle));
    }
    awake.fade(&case.avatar.fine, |_| 2.0 / 3.0);
    awake.fade(&case.avatar.fine, |_| 0.0);
    (case, awake)
}

/// Its states with what sleeps at 0.
fn states(case: &Case, awake: usize) -> [State; 3] {
    case.states().map(|mut state| {
        let first = case.avatar.coarse_handles() + awake;
        state.handles[first..].fill(DVec3::ZERO);
        state
    })
}

fn begun(case: &Case, awake: &Awake) -> CpuPotential {
    let mut potential = CpuPotential::new(Arc::new(case.avatar.clone()), 1).unwrap();
    potential.wake(0, awake).unwrap();
    let [previous, current, _] = states(case, awake.handles().len());
    let start = case.start(&previous, &current);
    block_on(potential.begin_step(&[start], &[true])).unwrap();
    potential
}

#[test]
fn each_term_has_true_derivatives() {
    for case in cases() {
        let (case, awake) = with_fine(case);
        let name = case.name;
        let mut potential = begun(&case, &awake);
        let [_, current, state] = states(&case, AWAKE.len());
        let evaluation = evaluate(&mut potential, &state);
        let total = evaluation.energies.total();
        let expected = difference(&mut potential, &current, &state);
        assert!((total - expected).abs() < 1e-10 * total.abs(), "{name}");

        // What is awake, and not the slot that is not taken.
        let dofs = evaluation.gradient.len() - 3;
        assert!(evaluation.gradient[dofs..].iter().all(|g| *g == 0.0));
        let scale = largest(evaluation.gradient.iter().copied());
        let of_slots = dofs - 3 * AWAKE.len()..dofs;
        let moved = largest(evaluation.gradient[of_slots.clone()].iter().copied());
        assert!(moved > 1e-6 * scale, "{name}: {moved} of {scale}");
        let mut columns = Vec::new();
        for k in 0..dofs {
            let e = unit(dofs + 3, k);
            let [ahead, behind] =
                [STEP, -STEP].map(|step| evaluate(&mut potential, &state.moved(&e, step)));
            let change = ahead.energies.total() - behind.energies.total();
            let error = (evaluation.gradient[k] - change / (2.0 * STEP)).abs();
            assert!(error < 1e-5 * scale, "{name}, {k}: {error} of {scale}");
            let pairs = ahead.gradient.iter().zip(&behind.gradient);
            columns.push(
                pairs
                    .map(|(a, b)| (a - b) / (2.0 * STEP))
                    .collect::<Vec<_>>(),
            );
        }
        let exact = potential
            .dense_hessian(0, &state, HessianForm::Exact)
            .unwrap();
        let scale = largest(exact.iter().flatten().copied());
        for i in 0..dofs {
            for k in 0..=i {
                let expected = 0.5 * (columns[k][i] + columns[i][k]);
                let error = (exact[i][k] - expected).abs();
                assert!(
                    error < 2e-5 * scale,
                    "{name}, ({i}, {k}): {error} of {scale}"
                );
            }
        }
        // The packed blocks are the solver's, row for row, and end with the last slot that is taken.
        let solver = potential
            .dense_hessian(0, &state, HessianForm::Solver)
            .unwrap();
        let scale = largest(solver.iter().flatten().copied());
        let blocks: Vec<_> = potential.pattern().blocks().collect();
        let rows = blocks[..evaluation.hessian.len()].iter().map(|b| b.0);
        assert_eq!(rows.max(), Some(dofs / 3 - 1));
        let mut seen = vec![vec![false; dofs]; dofs];
        for (&(row, column), block) in blocks.iter().zip(&evaluation.hessian) {
            for m in 0..9 {
                let (r, c) = (3 * row + m % 3, 3 * column + m / 3);
                (seen[r][c], seen[c][r]) = (true, true);
                let error = (block[m] - solver[r][c]).abs();
                assert!(error < 1e-12 * scale, "{name}, ({r}, {c})");
            }
        }
        for (r, seen) in seen.iter().enumerate() {
            for (c, seen) in seen.iter().enumerate() {
                assert!(
                    *seen || solver[r][c] == 0.0,
                    "{name}: ({r}, {c}) is left out"
                );
            }
        }
    }
}

#[test]
fn with_none_awake_the_bits_are_those_of_an_avatar_without() {
    for case in cases() {
        let name = case.name;
        let mut plain = case.reference();
        let (case, _) = with_fine(case);
        let none = Awake::none(&case.avatar);
        let [_, _, mut state] = states(&case, 0);
        let mut slots = begun(&case, &none);
        let with = evaluate(&mut slots, &state);
        state.handles.truncate(case.avatar.coarse_handles());
        // The states are drawn number by number: those of fewer handles differ.
        let [previous, current, _] = states(&case, 0).map(|mut state| {
            state.handles.truncate(case.avatar.coarse_handles());
            state
        });
        let start = case.start(&previous, &current);
        block_on(plain.begin_step(&[start], &[true])).unwrap();
        let without = evaluate(&mut plain, &state);
        assert_eq!(with.energies, without.energies, "{name}");
        assert_eq!(with.contact_force, without.contact_force, "{name}");
        let dofs = without.gradient.len();
        assert_eq!(with.gradient[..dofs], without.gradient, "{name}");
        assert!(with.gradient[dofs..].iter().all(|g| *g == 0.0));
        let pattern = slots.pattern();
        let mut found = 0;
        for ((row, column), block) in plain.pattern().blocks().zip(&without.hessian) {
            let at = pattern.find(row, column).unwrap();
            assert_eq!(with.hessian[at], *block, "{name}");
            found += 1;
        }
        // What children of cells would add is there, and empty.
        let nothing = with.hessian.iter().filter(|block| **block == [0.0; 9]);
        assert!(nothing.count() >= with.hessian.len() - found);
    }
}

fn skin(potential: &mut CpuPotential, state: &State) -> Vec<DVec3> {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    block_on(async {
        let states = std::slice::from_ref(state);
        potential
            .pose_skin(states, &[], &[PreviousSkin::Kept])
            .await?;
        potential.read_skin(0, &mut positions, &mut normals).await
    })
    .unwrap();
    positions
}

#[test]
fn waking_changes_nothing_and_slots_may_change_places() {
    let (case, awake) = with_fine(cases().pop().unwrap());
    let avatar = &case.avatar;
    let [_, _, mut state] = states(&case, 0);
    let asleep = evaluate(&mut begun(&case, &Awake::none(avatar)), &state);
    let mut fresh = Awake::none(avatar);
    for handle in AWAKE {
        assert!(fresh.wake(
            &avatar.fine,
            avatar.coarse_handles(),
            handle,
            std::iter::once(&mut state)
        ));
    }
    assert!(fresh.cells().iter().all(|cell| cell.1 == 0.0));
    let woken = evaluate(&mut begun_asleep(&case, &fresh), &state);
    let coarse = 6 * avatar.skeleton.len() + 3 * avatar.coarse_handles();
    let scale = largest(asleep.gradient.iter().copied());
    for (a, b) in asleep.gradient[..coarse].iter().zip(&woken.gradient) {
        assert!((a - b).abs() < 1e-12 * scale, "{a} {b}");
    }

    // Both orders of the same handles.
    let [_, _, moved] = states(&case, AWAKE.len());
    let mut other = Awake::none(avatar);
    let mut exchanged = moved.clone();
    let first = avatar.coarse_handles();
    exchanged.handles.swap(first, first + 1);
    for handle in AWAKE.into_iter().rev() {
        assert!(wake(&mut other, avatar, handle));
    }
    other.fade(&avatar.fine, |_| 2.0 / 3.0);
    let skins = [(&awake, &moved), (&other, &exchanged)]
        .map(|(awake, state)| skin(&mut begun(&case, awake), state));
    let rest = skin(&mut begun(&case, &Awake::none(avatar)), &moved);
    let apart = |a: &[DVec3], b: &[DVec3]| largest(a.iter().zip(b).map(|(a, b)| a.distance(*b)));
    assert!(apart(&skins[0], &skins[1]) < 1e-14);
    assert!(
        apart(&skins[0], &rest) > 1e-4,
        "handles that are awake move the skin"
    );

    // The one in the first slot sleeps: the other takes its place, in the states too.
    let mut left = awake.clone();
    let mut state = moved.clone();
    let other = state.handles[first + 1];
    left.sleep(first, 0, std::iter::once(&mut state));
    assert_eq!(left.handles(), [AWAKE[1]]);
    assert_eq!(state.handles[first..first + 2], [other, DVec3::ZERO]);
    left.validate(avatar).unwrap();
    // Its cells fade, those of the other stay.
    left.fade(&avatar.fine, |_| 1.0);
    let cells: Vec<u32> = left.cells().iter().map(|c| c.0).collect();
    assert_eq!(cells, avatar.fine.cells.row(AWAKE[1] as usize));
    assert!(left.cells().iter().all(|cell| cell.1 == 1.0));
    let full = [0, 2, 4].map(|h| wake(&mut left, avatar, h));
    assert_eq!(full, [true, true, false]);
}

/// The step starts from states in which nothing that sleeps has moved.
fn begun_asleep(case: &Case, awake: &Awake) -> CpuPotential {
    let mut potential = CpuPotential::new(Arc::new(case.avatar.clone()), 1).unwrap();
    potential.wake(0, awake).unwrap();
    let [previous, current, _] = states(case, 0);
    let start = case.start(&previous, &current);
    block_on(potential.begin_step(&[start], &[true])).unwrap();
    potential
}

#[test]
fn what_is_not_there_is_refused() {
    let (case, awake) = with_fine(cases().pop().unwrap());
    let without = Avatar {
        fine: Arc::default(),
        ..case.avatar.clone()
    };
    let mut potential = CpuPotential::new(Arc::new(without), 1).unwrap();
    let error = potential.wake(0, &awake).unwrap_err().to_string();
    assert!(error.contains("awake"), "{error}");
    let error = case.avatar.clone().with_fine_slots(1).unwrap_err();
    assert!(error.to_string().contains("fine.slots"), "{error}");
    let error = supple::file::AvatarFile::new(case.avatar.clone());
    let error = error.to_bytes(Default::default()).unwrap_err().to_string();
    assert!(error.contains("fine.slots"), "{error}");
    // A budget above what is there is capped.
    let mut avatar = case.avatar;
    let slots = Arc::make_mut(&mut avatar.fine);
    slots.slots = 0;
    avatar.handles.truncate(6);
    let avatar = avatar.with_fine_slots(100).unwrap();
    assert_eq!(avatar.fine.slots, FINE);
    assert_eq!(avatar.handles.len(), avatar.coarse_handles() + FINE);
    let identity = DMat3::IDENTITY;
    assert!(
        avatar
            .rest_state()
            .frames
            .iter()
            .all(|f| f.rotation == identity)
    );
}
