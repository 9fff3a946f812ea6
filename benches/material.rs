//! What a law costs at a cubature point: stress, projected tangent and energy difference at mild strains, and at strains
//! where some of the eigenvalues are negative.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use supple::glam::DMat3;
use supple::internal::math::Random;
use supple::material::Material;

/// Deformation gradients with entries up to `size` away from rest.
fn samples(size: f64) -> Vec<[DMat3; 2]> {
    let random = &mut Random::new(1);
    let mut matrix =
        |size: f64| DMat3::from_cols_array(&std::array::from_fn(|_| random.uniform(-size, size)));
    (0..256)
        .map(|_| [DMat3::IDENTITY + matrix(size), matrix(0.01)])
        .collect()
}

fn bench(criterion: &mut Criterion) {
    for (strain, size) in [("mild", 0.05), ("large", 0.4)] {
        let samples = samples(size);
        for material in Material::examples() {
            let law = material.kernels().last().unwrap_or(&"");
            let name = format!("material/{law}/256 points, {strain} strain");
            criterion.bench_function(&name, |b| {
                b.iter(|| {
                    for &[f, change] in black_box(&samples) {
                        black_box(material.pk1_stress(f));
                        black_box(material.projected_tangent(f));
                        black_box(material.energy_difference(f, change));
                    }
                });
            });
        }
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
