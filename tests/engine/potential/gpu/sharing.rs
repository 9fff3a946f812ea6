//! Several potentials: with the same kernels, and in the same submission.

use super::case::{Case, Outcome, case, device, joined, potential, run, start};
use std::sync::Arc;
use supple::gpu::{Waiting, required_limits};
use supple::internal::gpu_plumbing::{Patience, Submission};
use supple::internal::random_avatar;
use supple::material::Material;
use supple::model::{Avatar, State};
use supple::potential::{
    Difference, Evaluation, GpuKernels, GpuOptions, GpuPotential, Potential, StepEnd, StepStart,
    Trial,
};
use supple::{Error, Result, wgpu};

const PATIENCE: Patience = Patience {
    waiting: Waiting::Block,
    timeout: std::time::Duration::from_secs(60),
};

#[test]
fn potentials_of_any_assets_share_kernels() {
    let gpu = device();
    let (device, queue) = (&gpu.device, &gpu.queue);
    let avatars = [
        random_avatar(7, 6, 12, 150, 300),
        random_avatar(8, 3, 5, 40, 100),
    ]
    .map(Arc::new);
    let kernels = GpuKernels::compile_blocking(device, &avatars[0].material, None).unwrap();
    for avatar in &avatars {
        let case = case(2, avatar);
        let mut sharing = GpuPotential::with_kernels(
            device,
            queue,
            &kernels.clone(),
            avatar.clone(),
            1,
            GpuOptions::default(),
        )
        .unwrap();
        let mut alone = potential(&gpu, avatar, 1, GpuOptions::default());
        assert_eq!(run(&mut sharing, &[&case]), run(&mut alone, &[&case]));
    }
}

#[test]
fn kernels_of_another_law_or_device_are_refused() {
    // Two devices of one adapter: those of two wgpu instances cannot be told apart.
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    let instance = wgpu::Instance::new(descriptor);
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let open = || {
        let adapter = (adapters.iter())
            .find(|a| required_limits().check_limits(&a.limits()))
            .expect("an adapter");
        pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            required_limits: required_limits(),
            ..Default::default()
        }))
        .unwrap()
    };
    let ((device, queue), (other_device, _)) = (open(), open());
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    let with = |kernels: Result<GpuKernels>| {
        let (options, avatar) = (GpuOptions::default(), avatar.clone());
        GpuPotential::with_kernels(&device, &queue, &kernels?, avatar, 1, options)
    };
    let own = &avatar.material;
    let other = (Material::examples().into_iter())
        .find(|m| m.kernels() != own.kernels())
        .unwrap();
    for (compiled_for, material, problem) in [
        (&device, &other, "material law"),
        (&other_device, own, "another device"),
    ] {
        match with(GpuKernels::compile_blocking(compiled_for, material, None)) {
            Err(Error::Invalid { problem: said, .. }) => assert!(said.contains(problem), "{said}"),
            other => panic!("{problem}: {other:?}"),
        }
    }
    assert!(with(GpuKernels::compile_blocking(&device, own, None)).is_ok());
}

/// Asks all potentials the same as [`run`], but together.
fn run_together(
    potentials: &mut [GpuPotential],
    cases: &[Vec<&Case>],
    submission: &mut Submission,
) -> Vec<Outcome> {
    let all = |n: usize| vec![true; n];
    let mut out: Vec<Outcome> = cases.iter().map(|_| Outcome::default()).collect();
    for (potential, cases) in potentials.iter_mut().zip(cases) {
        let starts: Vec<_> = cases.iter().map(|c| start(c)).collect();
        let recorder = potential.recorder();
        recorder
            .record_begin_step(&starts, &all(cases.len()), submission)
            .unwrap();
    }
    for k in 0..2 {
        let states =
            |cases: &[&Case]| -> Vec<State> { cases.iter().map(|c| c.states[k].clone()).collect() };
        for (potential, cases) in potentials.iter_mut().zip(cases) {
            let recorder = potential.recorder();
            recorder
                .record_evaluate(&states(cases), &all(cases.len()), submission)
                .unwrap();
        }
        let bytes = pollster::block_on(submission.read()).unwrap();
        for ((potential, cases), out) in potentials.iter_mut().zip(cases).zip(&mut out) {
            let mut evaluations = vec![Evaluation::default(); cases.len()];
            let recorder = potential.recorder();
            recorder
                .finish_evaluate(&bytes, &states(cases), &mut evaluations)
                .unwrap();
            out.evaluations.extend(evaluations);
        }
    }
    let states =
        |cases: &[&Case]| -> Vec<State> { cases.iter().map(|c| c.states[1].clone()).collect() };
    for (potential, cases) in potentials.iter_mut().zip(cases) {
        let recorder = potential.recorder();
        recorder
            .record_end_step(&states(cases), &all(cases.len()), submission)
            .unwrap();
    }
    let bytes = pollster::block_on(submission.read()).unwrap();
    for ((potential, cases), out) in potentials.iter_mut().zip(cases).zip(&mut out) {
        out.ends = vec![StepEnd::default(); cases.len()];
        let recorder = potential.recorder();
        recorder.finish_end_step(&bytes, &mut out.ends).unwrap();
    }
    drop(bytes);
    for (from, to) in [(0, 1), (1, 2)] {
        for (potential, cases) in potentials.iter_mut().zip(cases) {
            let trial = |(instance, c): (usize, &&'_ Case)| -> (usize, State, State) {
                (instance, c.states[from].clone(), c.states[to].clone())
            };
            let owned: Vec<_> = cases.iter().enumerate().map(trial).collect();
            let trials: Vec<Trial<'_>> = (owned.iter())
                .map(|(instance, base, state)| Trial {
                    instance: *instance,
                    base,
                    state,
                })
                .collect();
            let recorder = potential.recorder();
            let count = recorder.record_energy_differences(&trials, submission);
            assert_eq!(count.unwrap(), trials.len());
        }
        let bytes = pollster::block_on(submission.read()).unwrap();
        for ((potential, cases), out) in potentials.iter_mut().zip(cases).zip(&mut out) {
            let mut differences = vec![Difference::default(); cases.len()];
            let recorder = potential.recorder();
            recorder
                .finish_energy_differences(&bytes, &mut differences)
                .unwrap();
            out.differences.extend(differences);
        }
    }
    for (potential, cases) in potentials.iter_mut().zip(cases) {
        let states: Vec<State> = cases.iter().map(|c| c.states[0].clone()).collect();
        let offsets: Vec<_> = cases.iter().map(|c| &c.offsets[..]).collect();
        let recorder = potential.recorder();
        recorder
            .record_pose_skin(&states, &offsets, &[], submission)
            .unwrap();
    }
    submission.flush();
    for ((potential, cases), out) in potentials.iter_mut().zip(cases).zip(&mut out) {
        for i in 0..cases.len() {
            let (mut positions, mut normals) = (Vec::new(), Vec::new());
            pollster::block_on(potential.read_skin(i, &mut positions, &mut normals)).unwrap();
            out.skins.push((positions, normals));
        }
    }
    out
}

#[test]
fn potentials_in_one_submission_give_the_bits_of_lone_runs() {
    let gpu = device();
    let avatars: Vec<Arc<Avatar>> = [
        random_avatar(7, 6, 12, 150, 300),
        random_avatar(8, 3, 5, 40, 100),
    ]
    .map(Arc::new)
    .into();
    let cases: Vec<Vec<Case>> = vec![
        (1..3).map(|seed| case(seed, &avatars[0])).collect(),
        vec![case(3, &avatars[1])],
    ];
    let lone: Vec<Outcome> = (avatars.iter().zip(&cases))
        .map(|(avatar, cases)| {
            let alone = |case| {
                let mut alone = potential(&gpu, avatar, 1, GpuOptions::default());
                run(&mut alone, &[case])
            };
            joined(&cases.iter().map(alone).collect::<Vec<_>>())
        })
        .collect();
    // Also where a potential's states go through its scratch memory one by one.
    for scratch_bytes in [1, 128 << 20] {
        let mut potentials: Vec<GpuPotential> = (avatars.iter().zip(&cases))
            .map(|(avatar, cases)| {
                let options = GpuOptions {
                    scratch_bytes,
                    ..GpuOptions::default()
                };
                potential(&gpu, avatar, cases.len(), options)
            })
            .collect();
        let room = (potentials.iter_mut())
            .map(|p| p.recorder().room_to_read())
            .sum();
        let (device, queue) = (&gpu.device, &gpu.queue);
        let mut submission = Submission::new(device, queue, "world", room, PATIENCE).unwrap();
        let cases: Vec<Vec<&Case>> = cases.iter().map(|c| c.iter().collect()).collect();
        // A second step finds the skin posed, and the buffers written.
        for step in 0..2 {
            let together = run_together(&mut potentials, &cases, &mut submission);
            assert!(together == lone, "scratch {scratch_bytes}, step {step}");
        }
    }
}

#[test]
fn what_a_step_recorded_is_sent_whatever_comes_next() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(7, 6, 12, 150, 300));
    let cases = [case(1, &avatar), case(2, &avatar)];
    let starts: Vec<StepStart<'_>> = cases.iter().map(start).collect();
    let states = cases.each_ref().map(|c| c.states[0].clone());
    let trial = Trial {
        instance: 1,
        base: &cases[1].states[0],
        state: &cases[1].states[1],
    };
    let new = || potential(&gpu, &avatar, 2, GpuOptions::default());
    pollster::block_on(async {
        let mut plain = new();
        let mut want = vec![Evaluation::default(); 2];
        plain.begin_step(&starts, &[true; 2]).await?;
        plain.evaluate(&states, &[true; 2], &mut want).await?;
        let mut difference = [Difference::default()];
        plain.energy_differences(&[trial], &mut difference).await?;
        plain.pose_skin(&states, &[], &[]).await?;
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        plain.read_skin(1, &mut positions, &mut normals).await?;

        let mut got = vec![Evaluation::default(); 2];
        // The start of one after the start of the other.
        let mut split = new();
        split.begin_step(&starts, &[true, false]).await?;
        split.begin_step(&starts, &[false, true]).await?;
        split.evaluate(&states, &[true; 2], &mut got).await?;
        assert_eq!(got, want);
        // A trial first.
        let mut tried = new();
        let mut first = [Difference::default()];
        tried.begin_step(&starts, &[true; 2]).await?;
        tried.energy_differences(&[trial], &mut first).await?;
        assert_eq!(first, difference);
        tried.evaluate(&states, &[true; 2], &mut got).await?;
        assert_eq!(got, want);
        // The skin first.
        let mut posed = new();
        posed.begin_step(&starts, &[true; 2]).await?;
        posed.pose_skin(&states, &[], &[]).await?;
        let (mut at, mut along) = (Vec::new(), Vec::new());
        posed.read_skin(1, &mut at, &mut along).await?;
        assert_eq!((at, along), (positions, normals));
        posed.evaluate(&states, &[true; 2], &mut got).await?;
        assert_eq!(got, want);
        // An evaluation that is refused.
        let mut refused = new();
        let mut broken = states.clone();
        broken[0].handles[0].x = f64::NAN;
        refused.begin_step(&starts, &[true; 2]).await?;
        let error = refused.evaluate(&broken, &[true; 2], &mut got).await;
        assert!(matches!(error, Err(Error::NotFinite { .. })), "{error:?}");
        refused.evaluate(&states, &[true; 2], &mut got).await?;
        assert_eq!(got, want);
        Ok::<_, Error>(())
    })
    .unwrap();
}
