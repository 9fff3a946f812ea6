//! Structs shared with the kernels lie where the kernels' compiler puts them, and the kernels keep to
//! what every WebGPU device offers.

use std::collections::HashSet;
use supple::gpu::required_limits;
use supple::internal::gpu::shared::SHARED_STRUCTS;
use supple::internal::gpu::{Sources, modules};
use supple::material::Material;

/// Structs that no buffer holds: they live in registers only.
const LOCAL_STRUCTS: &[&str] = &[
    "Eigen",
    "SingularValues",
    "SignedDistance",
    "Fibres",
    "Matrix9",
    "Run",
];

#[test]
fn shared_structs_lie_where_the_kernels_expect_them() {
    let mut seen = HashSet::new();
    let materials = Material::examples();
    for material in &materials {
        let parameters = material.parameters();
        assert_eq!(parameters.bytes.len(), parameters.layout.size);
        let shared: Vec<_> = (SHARED_STRUCTS.iter())
            .chain([&parameters.layout])
            .collect();
        for module in modules(&Sources::new(material)).unwrap() {
            for layout in &shared {
                let Some((size, fields)) = module.struct_layout(layout.name) else {
                    continue;
                };
                seen.insert(layout.name);
                assert_eq!(size, layout.size, "size of {}", layout.name);
                let named = |name: &str| !name.starts_with('_');
                let host: Vec<_> = (layout.fields.iter())
                    .filter(|(name, _)| named(name))
                    .map(|&(name, offset)| (name.to_owned(), offset))
                    .collect();
                let kernel: Vec<_> = fields.into_iter().filter(|(name, _)| named(name)).collect();
                assert_eq!(kernel, host, "fields of {}", layout.name);
            }
            for name in module.structs() {
                let known = shared.iter().any(|layout| layout.name == name);
                assert!(
                    known || LOCAL_STRUCTS.contains(&name),
                    "{name} is not checked"
                );
            }
        }
    }
    let count = SHARED_STRUCTS.len() + materials.len();
    assert_eq!(seen.len(), count, "a struct is in no kernel");
}

#[test]
fn kernels_keep_to_the_limits_every_device_has() {
    let limit = required_limits().max_storage_buffers_per_shader_stage as usize;
    assert_eq!(limit, 8);
    for material in Material::examples() {
        for module in modules(&Sources::new(&material)).unwrap() {
            for entry in module.entry_points() {
                let used = module.storage_buffers(entry).unwrap();
                assert!(used <= limit, "{entry} binds {used} storage buffers");
            }
        }
    }
}
