//! Futures: who drives the device, how long one waits, and what remains of one that is dropped.

use super::case::{case, device, potential, run, start};
use std::future::Future;
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Waker};
use std::time::Duration;
use supple::gpu::{GpuDevice, Waiting};
use supple::internal::random_avatar;
use supple::potential::{
    CpuPotential, Difference, Evaluation, GpuOptions, Potential, StepEnd, Trial,
};
use supple::{Error, GpuError, wgpu};

#[test]
fn a_host_may_drive_the_device() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let blocking = run(
        &mut potential(&gpu, &avatar, 1, GpuOptions::default()),
        &[&case],
    );
    let options = GpuOptions {
        waiting: Waiting::Host,
        ..GpuOptions::default()
    };
    let mut waiting = potential(&gpu, &avatar, 1, options);
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                gpu.device.poll(wgpu::PollType::Poll).unwrap();
                std::thread::yield_now();
            }
        });
        let outcome = run(&mut waiting, &[&case]);
        done.store(true, Ordering::Relaxed);
        assert_eq!(outcome, blocking);
    });
}

/// Asks once; whether it was ready.
fn ask_once<T>(future: impl Future<Output = T>) -> bool {
    let mut context = Context::from_waker(Waker::noop());
    matches!(pin!(future).poll(&mut context), Poll::Ready(_))
}

#[test]
fn a_dropped_future_leaves_nothing_mapped() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let options = GpuOptions {
        waiting: Waiting::Host,
        ..GpuOptions::default()
    };
    let mut dropped = potential(&gpu, &avatar, 1, options);
    let states = [case.states[0].clone()];
    pollster::block_on(dropped.begin_step(&[start(&case)], &[true])).unwrap();
    let mut out = [Evaluation::default()];
    let mut pending = 0;
    for _ in 0..3 {
        pending += usize::from(!ask_once(dropped.evaluate(&states, &[true], &mut out)));
        let trial = Trial {
            instance: 0,
            base: &case.states[0],
            state: &case.states[1],
        };
        pending += usize::from(!ask_once(
            dropped.energy_differences(&[trial], &mut [Difference::default()]),
        ));
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        pending += usize::from(!ask_once(dropped.read_skin(
            0,
            &mut positions,
            &mut normals,
        )));
    }
    assert_eq!(pending, 9, "nobody drives the device");
    assert_eq!(out, [Evaluation::default()]);
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                gpu.device.poll(wgpu::PollType::Poll).unwrap();
                std::thread::yield_now();
            }
        });
        let outcome = run(&mut dropped, &[&case]);
        done.store(true, Ordering::Relaxed);
        let mut whole = potential(&gpu, &avatar, 1, GpuOptions::default());
        assert_eq!(outcome, run(&mut whole, &[&case]));
    });
}

/// Gives the queue half a gigabyte to copy, so that what is submitted next is surely not done at once.
fn occupy(gpu: &GpuDevice) {
    const BYTES: u64 = 64 << 20;
    let buffer = || {
        gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("what keeps the device busy"),
            size: BYTES,
            usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let (a, b) = (buffer(), buffer());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    for _ in 0..4 {
        encoder.copy_buffer_to_buffer(&a, 0, &b, 0, BYTES);
        encoder.copy_buffer_to_buffer(&b, 0, &a, 0, BYTES);
    }
    gpu.queue.submit([encoder.finish()]);
}

#[test]
fn a_device_that_takes_too_long_is_an_error_and_the_next_question_is_answered() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let options = GpuOptions {
        timeout: Duration::ZERO,
        ..GpuOptions::default()
    };
    let mut hasty = potential(&gpu, &avatar, 1, options);
    let states = [case.states[0].clone()];
    let mut out = [Evaluation::default()];
    pollster::block_on(hasty.begin_step(&[start(&case)], &[true])).unwrap();
    let mut timeouts = 0;
    // A thread that is held up between submitting and asking finds the device done even so.
    for _ in 0..100 {
        occupy(&gpu);
        out[0] = Evaluation::default();
        let Err(error) = pollster::block_on(hasty.evaluate(&states, &[true], &mut out)) else {
            continue;
        };
        let text = error.to_string();
        assert!(
            matches!(error, Error::Gpu(GpuError::Timeout { waited, .. }) if waited.is_zero()),
            "{text}"
        );
        assert!(text.contains("results of the tissue") && text.contains("GpuOptions::timeout"));
        assert_eq!(out, [Evaluation::default()]);
        timeouts += 1;
        if timeouts == 2 {
            return;
        }
    }
    panic!("{timeouts} of 100 waits without patience were too long");
}

#[test]
fn what_the_host_waits_for_brings_results_as_well() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let mut waiting = potential(
        &gpu,
        &avatar,
        1,
        GpuOptions {
            waiting: Waiting::Host,
            ..GpuOptions::default()
        },
    );
    let mut out = [Evaluation::default()];
    let states = [case.states[0].clone()];
    pollster::block_on(waiting.begin_step(&[start(&case)], &[true])).unwrap();
    let mut evaluation = pin!(waiting.evaluate(&states, &[true], &mut out));
    let mut context = Context::from_waker(Waker::noop());
    assert!(evaluation.as_mut().poll(&mut context).is_pending());
    // The host's own submissions neither disturb it nor are disturbed.
    let index = gpu.queue.submit([]);
    let waited = wgpu::PollType::Wait {
        submission_index: Some(index),
        timeout: Some(Duration::from_secs(60)),
    };
    gpu.device.poll(waited).unwrap();
    assert!(evaluation.as_mut().poll(&mut context).is_ready());
}

fn is_send<T: Send>(_: T) {}

#[test]
fn futures_may_go_to_other_threads() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let (starts, states) = ([start(&case)], [case.states[0].clone()]);
    let trials = [Trial {
        instance: 0,
        base: &case.current,
        state: &case.states[0],
    }];
    let (mut out, mut ends) = ([Evaluation::default()], [StepEnd::default()]);
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let mut on_gpu = potential(&gpu, &avatar, 1, GpuOptions::default());
    is_send(on_gpu.begin_step(&starts, &[true]));
    is_send(on_gpu.evaluate(&states, &[true], &mut out));
    is_send(on_gpu.energy_differences(&trials, &mut [Difference::default()]));
    is_send(on_gpu.end_step(&states, &[true], &mut ends));
    is_send(on_gpu.pose_skin(&states, &[], &[]));
    is_send(on_gpu.read_skin(0, &mut positions, &mut normals));
    let mut on_cpu = CpuPotential::new(avatar.clone(), 1).unwrap();
    is_send(on_cpu.begin_step(&starts, &[true]));
    is_send(on_cpu.evaluate(&states, &[true], &mut out));
    is_send(on_cpu.energy_differences(&trials, &mut [Difference::default()]));
    is_send(on_cpu.end_step(&states, &[true], &mut ends));
    is_send(on_cpu.pose_skin(&states, &[], &[]));
    is_send(on_cpu.read_skin(0, &mut positions, &mut normals));
    is_send(GpuDevice::open(Default::default()));
    let (device, law) = (&gpu.device, &avatar.material);
    is_send(supple::potential::GpuKernels::compile(device, law, None));
}
