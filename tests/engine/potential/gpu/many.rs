//! Many instances, and numbers beyond what f32 holds.

use super::case::{Case, Outcome, case, device, potential, run, start};
use std::sync::Arc;
use supple::internal::random_avatar;
use supple::model::State;
use supple::potential::{Difference, Evaluation, GpuOptions, GpuPotential, Potential, Trial};
use supple::{Error, GpuError};

#[test]
fn two_hundred_instances_give_the_bits_of_lone_runs() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    let different: Vec<Case> = (0..4).map(|seed| case(seed, &avatar)).collect();
    let lone: Vec<Outcome> = (different.iter())
        .map(|case| {
            let mut alone = potential(&gpu, &avatar, 1, GpuOptions::default());
            run(&mut alone, &[case])
        })
        .collect();
    let cases: Vec<&Case> = different.iter().cycle().take(200).collect();
    let options = GpuOptions {
        contacts: 512,
        ..GpuOptions::default()
    };
    let all = run(&mut potential(&gpu, &avatar, 200, options), &cases);
    for i in 0..200 {
        let lone = &lone[i % 4];
        for k in 0..2 {
            assert_eq!(all.evaluations[200 * k + i], lone.evaluations[k], "{i}");
            assert_eq!(all.differences[200 * k + i], lone.differences[k], "{i}");
        }
        assert_eq!(all.skins[i], lone.skins[0], "{i}");
    }
}

#[test]
fn too_many_instances_are_refused_with_how_many_fit() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    // Room for contacts that nobody has: 80 bytes and more for each of every instance.
    let with = |instances| {
        let options = GpuOptions {
            contacts: 100_000,
            ..GpuOptions::default()
        };
        let (device, queue) = (&gpu.device, &gpu.queue);
        GpuPotential::new(device, queue, avatar.clone(), instances, options)
    };
    for many in [100_000, usize::MAX] {
        match with(many) {
            Err(Error::Gpu(GpuError::Limit {
                what,
                needed,
                limit,
                ..
            })) => {
                assert!(what.contains("instances"), "{what}");
                assert_eq!(needed, many as u64);
                assert!((1..60_000).contains(&limit), "{limit}");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn numbers_that_overflow_are_told() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let mut on_device = potential(&gpu, &avatar, 1, GpuOptions::default());
    pollster::block_on(async {
        on_device.begin_step(&[start(&case)], &[true]).await?;
        let mut want = [Difference::default()];
        let good = Trial {
            instance: 0,
            base: &case.states[0],
            state: &case.states[1],
        };
        on_device.energy_differences(&[good], &mut want).await?;
        let far = |reach: f64| {
            let mut state = case.states[1].clone();
            state.handles[1].x = reach;
            state
        };
        // Within f32 but not what comes of it, then beyond f32, then beyond all that a sum may be.
        for reach in [1e6, 1e20, 1e200, 1e308] {
            let far = far(reach);
            let trials = [
                good,
                Trial {
                    state: &far,
                    ..good
                },
                Trial { base: &far, ..good },
                good,
            ];
            let mut out = [Difference::default(); 4];
            on_device.energy_differences(&trials, &mut out).await?;
            assert_eq!([out[0], out[3]], [want[0]; 2], "{reach:e}");
            assert!(
                !out[1].energy.is_finite() && !out[2].energy.is_finite(),
                "{reach:e}: {out:?}"
            );

            let mut evaluation = [Evaluation::default()];
            let states: [State; 1] = [far];
            let error = on_device.evaluate(&states, &[true], &mut evaluation).await;
            assert!(matches!(error, Err(Error::NotFinite { .. })), "{error:?}");
            assert_eq!(evaluation, [Evaluation::default()]);
        }
        Ok::<_, Error>(())
    })
    .unwrap();
}
