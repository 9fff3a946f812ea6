//! A typed error for everything that can go wrong.

use super::case::{case, device, potential, start};
use std::sync::Arc;
use supple::gpu::{AdapterChoice, AdapterKind, GpuDevice, adapters};
use supple::internal::gpu::Sources;
use supple::internal::gpu_plumbing::{Bindings, Module};
use supple::internal::random_avatar;
use supple::potential::{Evaluation, GpuKernels, GpuOptions, Potential, StepStart};
use supple::{Error, GpuError};

/// The GPU error of a result that must be one.
fn gpu_error<T>(result: supple::Result<T>) -> GpuError {
    match result {
        Err(Error::Gpu(error)) => error,
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("no error"),
    }
}

#[test]
fn what_goes_wrong_has_a_type() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(6, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let mut out = [Evaluation::default()];
    let mut on_device = potential(&gpu, &avatar, 1, GpuOptions::default());
    let state = [case.states[0].clone()];

    let result = pollster::block_on(on_device.evaluate(&state, &[true], &mut out));
    assert!(matches!(result, Err(Error::Invalid { .. })), "{result:?}");

    let mut broken = state.clone();
    broken[0].handles[2].y = f64::NAN;
    pollster::block_on(on_device.begin_step(&[start(&case)], &[true])).unwrap();
    let result = pollster::block_on(on_device.evaluate(&broken, &[true], &mut out));
    assert!(matches!(result, Err(Error::NotFinite { .. })), "{result:?}");

    // Finite in f64, but not what comes out of f32.
    broken[0].handles[2].y = 1e30;
    let result = pollster::block_on(on_device.evaluate(&broken, &[true], &mut out));
    assert!(matches!(result, Err(Error::NotFinite { .. })), "{result:?}");

    let many = vec![case.colliders[0].clone(); 9];
    let crowded = StepStart {
        colliders: &many,
        ..start(&case)
    };
    let error = gpu_error(pollster::block_on(
        on_device.begin_step(&[crowded], &[true]),
    ));
    assert!(matches!(error, GpuError::Limit { .. }), "{error}");

    let sources = Sources::new(&avatar.material)
        .edited("displacement.wgsl", "fn displacement(", "fn displacement((")
        .unwrap();
    let compiled = GpuKernels::compile_sources(&gpu.device, &sources, None);
    let error = gpu_error(pollster::block_on(compiled));
    assert!(matches!(error, GpuError::Shader { .. }), "{error}");
    assert!(error.to_string().contains("displacement"), "{error}");

    let source = "@group(0) @binding(0) var<storage, read_write> numbers: array<f32>;\n\
                  @compute @workgroup_size(1) fn main() { numbers[0] = 1.0; }";
    let module = Module::parse("lonely", source.to_owned()).unwrap();
    let (shader, taken) = module.shader(&gpu.device);
    pollster::block_on(taken).unwrap();
    let (pipeline, taken) = shader.pipeline("main", &[], None).unwrap();
    pollster::block_on(taken).unwrap();
    let error = gpu_error(pipeline.bind(&Bindings::default()));
    assert!(matches!(error, GpuError::MissingBuffer { .. }), "{error}");
    assert!(error.to_string().contains("numbers"), "{error}");
}

#[test]
fn a_lost_device_is_an_error() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(9, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let mut on_device = potential(&gpu, &avatar, 1, GpuOptions::default());
    pollster::block_on(on_device.begin_step(&[start(&case)], &[true])).unwrap();
    gpu.device.destroy();
    let state = std::slice::from_ref(&case.states[0]);
    let mut out = [Evaluation::default()];
    let error = gpu_error(pollster::block_on(on_device.evaluate(
        state,
        &[true],
        &mut out,
    )));
    assert!(matches!(error, GpuError::DeviceLost(_)), "{error}");
}

#[test]
fn adapters_are_listed_with_their_kind() {
    let gpu = device();
    let listed = pollster::block_on(adapters());
    assert!(listed.contains(&gpu.adapter));
    assert!(!gpu.adapter.name.is_empty() && !gpu.adapter.backend.is_empty());
    if listed.iter().all(|a| a.kind == AdapterKind::Software) {
        let refused = pollster::block_on(GpuDevice::open(AdapterChoice::Hardware));
        assert!(matches!(gpu_error(refused), GpuError::NoAdapter(_)));
    }
}
