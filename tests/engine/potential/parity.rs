//! Every kernel computes what its f64 twin computes, from the same numbers, to rounding.

use super::kernels::CHECKS;
use super::kernels::input::seeds;
use super::kernels::scene::{Scene, device};

#[test]
fn every_kernel_agrees_with_its_twin() {
    let gpu = device();
    let mut failures = Vec::new();
    for seed in seeds(3) {
        let scene = Scene::run(&gpu, seed, None).unwrap();
        for (kernel, check) in CHECKS {
            if let Err(problem) = check(&scene) {
                failures.push(format!("seed {seed}, {kernel}: {problem}"));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
