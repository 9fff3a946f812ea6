//! Structs shared with the kernels lie where the kernels' compiler puts them, and the kernels keep to
//! what every WebGPU device offers.

use std::collections::HashSet;
use supple::gpu::required_limits;
use supple::internal::gpu::shared::SHARED_STRUCTS;
use supple::internal::gpu::{Sources, modules};
use supple::material::Material;

/// Structs that no buffer holds: they live in registers only.
const LOCAL_STRUCTS: &[&str] = &["Eigen", "SingularValues", "SignedDistance", "Fibres", "Run"];

/// The names of the shared structs in the kernels of `material`, or the first that lies elsewhere than on the host.
fn compared(material: &Material, sources: &Sources) -> Result<HashSet<&'static str>, String> {
    let mut seen = HashSet::new();
    let parameters = material.parameters().layout;
    let shared: Vec<_> = SHARED_STRUCTS.iter().chain([&parameters]).collect();
    for module in modules(sources).unwrap() {
        for layout in &shared {
            let Some((size, fields)) = module.struct_layout(layout.name) else {
                continue;
            };
            seen.insert(layout.name);
            let named = |name: &str| !name.starts_with('_');
            let host: Vec<_> = (layout.fields.iter())
                .filter(|(name, _)| named(name))
                .map(|&(name, offset)| (name.to_owned(), offset))
                .collect();
            let kernel: Vec<_> = fields.into_iter().filter(|(name, _)| named(name)).collect();
            if (size, &kernel) != (layout.size, &host) {
                let name = layout.name;
                return Err(format!(
                    "{name}: {size} bytes, {kernel:?}; on the host {}, {host:?}",
                    layout.size
                ));
            }
        }
        for name in module.structs() {
            let known = shared.iter().any(|layout| layout.name == name);
            if !known && !LOCAL_STRUCTS.contains(&name) {
                return Err(format!("{name} is not checked"));
            }
        }
    }
    Ok(seen)
}

#[test]
fn shared_structs_lie_where_the_kernels_expect_them() {
    let mut seen = HashSet::new();
    let materials = Material::examples();
    for material in &materials {
        let parameters = material.parameters();
        assert_eq!(parameters.bytes.len(), parameters.layout.size);
        seen.extend(compared(material, &Sources::new(material)).unwrap());
    }
    let count = SHARED_STRUCTS.len() + materials.len();
    assert_eq!(seen.len(), count, "a struct is in no kernel");
}

#[test]
fn a_field_that_lies_elsewhere_is_noticed() {
    let swapped = [
        (
            "shared/batch.wgsl",
            "    instance: u32,\n    slot: u32,",
            "    slot: u32,\n    instance: u32,",
        ),
        (
            "material/stable_neo_hookean.wgsl",
            "mu: f32,      // Lamé's, Pa\n    lambda: f32,",
            "lambda: f32,\n    mu: f32,",
        ),
        (
            "material/orthotropic.wgsl",
            "root_fibre_moduli: vec3<f32>,      // √k, √Pa\n    root_saturation_rates: vec3<f32>,",
            "root_saturation_rates: vec3<f32>,\n    root_fibre_moduli: vec3<f32>,",
        ),
    ];
    let stiffening = (
        "material/fung_neo_hookean.wgsl",
        "stiffening: f32,        // b\n    stiffening_limit: f32,",
        "stiffening_limit: f32,\n    stiffening: f32,",
    );
    let unknown = (
        "shared/tissue.wgsl",
        "struct LocalTissue",
        "struct Lone { a: f32 }\n\nstruct LocalTissue",
    );
    for (path, from, to) in swapped.into_iter().chain([stiffening, unknown]) {
        let uses = |m: &Material| !path.starts_with("material") || m.kernels().contains(&path);
        let material = Material::examples().into_iter().find(uses).unwrap();
        let sources = Sources::new(&material).edited(path, from, to).unwrap();
        assert!(compared(&material, &sources).is_err(), "{path}: {to}");
    }
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
