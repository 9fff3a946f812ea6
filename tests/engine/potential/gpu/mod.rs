//! The potential on the device as a host sees it: the same bits whatever runs beside it, in step with the f64
//! evaluation, and a typed error for everything that can go wrong.

mod case;
mod errors;
mod few_contacts;
mod many;
mod offsets;
mod sharing;
mod waiting;

use case::{Case, Outcome, case, device, joined, potential, run, start};
use std::sync::Arc;
use supple::gpu::GpuDevice;
use supple::internal::{pose_offsets, random_avatar};
use supple::model::{Avatar, State};
use supple::potential::{CpuPotential, Evaluation, GpuOptions, Potential};

#[test]
fn a_batch_gives_each_avatar_the_bits_of_a_lone_run() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(7, 6, 12, 150, 300));
    let cases: Vec<Case> = (1..4).map(|seed| case(seed, &avatar)).collect();
    let lone: Vec<Outcome> = (cases.iter())
        .map(|c| {
            run(
                &mut potential(&gpu, &avatar, 1, GpuOptions::default()),
                &[c],
            )
        })
        .collect();
    assert!(lone.iter().all(|o| o.evaluations[0].contacts > 0));
    let cases: Vec<&Case> = cases.iter().collect();
    // Room for one state, for two and for all in the scratch buffers; trials in several submissions.
    for (scratch_bytes, trials) in [(1, 1), (5 << 20, 4), (128 << 20, 8)] {
        let options = GpuOptions {
            scratch_bytes,
            trials,
            ..GpuOptions::default()
        };
        let batch = run(&mut potential(&gpu, &avatar, 3, options), &cases);
        assert!(
            batch == joined(&lone),
            "scratch {scratch_bytes}, trials {trials}"
        );
    }
}

#[test]
fn the_same_input_gives_the_same_bits() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(3, 4, 8, 100, 200));
    let case = case(2, &avatar);
    let mut first = potential(&gpu, &avatar, 1, GpuOptions::default());
    let once = run(&mut first, &[&case]);
    // The second time x̄ of the drawn skin is of another pose than the step's start.
    assert_eq!(once, run(&mut first, &[&case]));
    let mut fresh = potential(&gpu, &avatar, 1, GpuOptions::default());
    assert_eq!(once, run(&mut fresh, &[&case]));
    // And here it is of the very pose, and carried over.
    let current = std::slice::from_ref(&case.current);
    pollster::block_on(fresh.pose_skin(current, &[&case.offsets], &[])).unwrap();
    assert_eq!(once, run(&mut fresh, &[&case]));
    // Of the very pose, but of other offsets or none.
    for offsets in [pose_offsets(5, &avatar, 5e-3), Vec::new()] {
        pollster::block_on(fresh.pose_skin(current, &[&offsets], &[])).unwrap();
        assert_eq!(once, run(&mut fresh, &[&case]));
    }
}

#[test]
fn inactive_instances_are_left_alone() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(4, 4, 8, 100, 200));
    let cases: Vec<Case> = (1..4).map(|seed| case(seed, &avatar)).collect();
    let mut potential = potential(&gpu, &avatar, 3, GpuOptions::default());
    let starts: Vec<_> = cases.iter().map(start).collect();
    pollster::block_on(async {
        potential.begin_step(&starts, &[true; 3]).await.unwrap();
        let states: Vec<State> = cases.iter().map(|c| c.states[0].clone()).collect();
        let mut all = vec![Evaluation::default(); 3];
        potential
            .evaluate(&states, &[true; 3], &mut all)
            .await
            .unwrap();
        let mut some = vec![Evaluation::default(); 3];
        let active = [false, false, true];
        potential
            .evaluate(&states, &active, &mut some)
            .await
            .unwrap();
        assert_eq!(some[2], all[2]);
        assert_eq!(some[..2], [Evaluation::default(), Evaluation::default()]);
        // A step begun by one alone changes nothing for the others.
        potential.begin_step(&starts, &active).await.unwrap();
        potential
            .evaluate(&states, &[true; 3], &mut some)
            .await
            .unwrap();
        assert_eq!(some, all);
        // Nobody at all.
        let nobody = [false; 3];
        potential.begin_step(&starts, &nobody).await.unwrap();
        potential
            .evaluate(&states, &nobody, &mut some)
            .await
            .unwrap();
        potential.energy_differences(&[], &mut []).await.unwrap();
        assert_eq!(some, all);
    });
}

#[test]
fn it_agrees_with_the_f64_evaluation() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(5, 6, 12, 150, 300));
    let touching = case(3, &avatar);
    let mut free = case(4, &avatar);
    free.colliders.clear();
    for case in [touching, free] {
        agrees(&gpu, &avatar, &case);
    }
    // The first collider is carried by a body, at its very place.
    let mut avatar = Avatar::clone(&avatar);
    let body = avatar.skeleton.len() as u32;
    avatar.skeleton.names.push("body".into());
    avatar.skeleton.parents.push(None);
    avatar.skeleton.joints.push(avatar.skeleton.joints[0]);
    avatar.bone_masses.push(avatar.bone_masses[0]);
    let avatar = Arc::new(avatar);
    let mut carried = case(3, &avatar);
    let place = carried.current.frames[body as usize];
    let collider = &mut carried.colliders[0];
    collider.body = Some(body);
    collider.frame = supple::model::Frame {
        rotation: place.rotation.transpose() * collider.frame.rotation,
        position: place.inverse_transform(collider.frame.position),
    };
    agrees(&gpu, &avatar, &carried);
}

fn agrees(gpu: &GpuDevice, avatar: &Arc<Avatar>, case: &Case) {
    let mut on_device = potential(gpu, avatar, 1, GpuOptions::default());
    let mut reference = CpuPotential::new(avatar.clone(), 1).unwrap();
    let (got, want) = (run(&mut on_device, &[case]), run(&mut reference, &[case]));
    // Some hundred roundings of 6e-8 in each of a few stages; tests of single kernels bound them sharply.
    let tolerance = 1e-4;
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    for (got, want) in got.evaluations.iter().zip(&want.evaluations) {
        assert_eq!(got.contacts, want.contacts);
        let pairs = || got.gradient.iter().zip(&want.gradient);
        let error = norm(&mut pairs().map(|(a, b)| a - b));
        let size = norm(&mut want.gradient.iter().copied());
        assert!(error <= tolerance * size, "gradient: {error} of {size}");
        let matrices = [
            ("Hessian", &got.hessian, &want.hessian),
            ("geometric terms", &got.geometric, &want.geometric),
        ];
        for (name, got_blocks, want_blocks) in matrices {
            assert_eq!(got_blocks.len(), want_blocks.len(), "{name}");
            let pairs = || {
                got_blocks
                    .iter()
                    .flatten()
                    .zip(want_blocks.iter().flatten())
            };
            let error = norm(&mut pairs().map(|(a, b)| a - b));
            let size = norm(&mut want_blocks.iter().flatten().copied());
            assert!(size > 0.0 || want.contacts == 0, "{name}");
            assert!(error <= tolerance * size, "{name}: {error} of {size}");
        }
        let force = (got.contact_force - want.contact_force).length();
        assert!(force <= tolerance * want.contact_force.length());
    }
    // A step's end is the evaluation's part by frames, of the same kernels.
    let (end, whole) = (&got.ends[0], &got.evaluations[1]);
    assert_eq!(
        end.frame_gradient,
        whole.gradient[..6 * avatar.skeleton.len()]
    );
    assert_eq!(end.energies, whole.energies);
    assert_eq!(end.contact_force, whole.contact_force);
    assert_eq!(
        (end.contacts, end.contacts_left_out),
        (whole.contacts, whole.contacts_left_out)
    );
    let zero = (got.evaluations[0]
        .hessian
        .iter()
        .filter(|b| **b == [0.0; 9]))
    .count();
    assert!(
        zero >= 4 * avatar.skeleton.len(),
        "{zero} blocks of the prescribed frame"
    );
    for (got, want) in got.skins[0].0.iter().zip(&want.skins[0].0) {
        assert!((*got - *want).length() < 1e-7, "skin: {got} and {want}");
    }
    for (got, want) in got.skins[0].1.iter().zip(&want.skins[0].1) {
        assert!((*got - *want).length() < 1e-4, "normals: {got} and {want}");
    }
    for (got, want) in got.differences.iter().zip(&want.differences) {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * b.abs();
        assert!(
            near(got.energy, want.energy),
            "trials: {got:?} and {want:?}"
        );
        // What opened or closed within rounding is of no force.
        let foreseen = near(got.pressing_force, want.pressing_force)
            && (got.unforeseen_force - want.unforeseen_force).abs() <= 1e-3 * want.pressing_force;
        assert!(foreseen, "trials: {got:?} and {want:?}");
    }
}
