//! The kernels keep to what FXC compiles, wgpu's compiler on Windows without DXC: of arrays of arrays, or arrays in
//! structs, that are local to a function and indexed by a variable it makes nothing (X3511).

use naga::{AddressSpace, Handle, Module, Type, TypeInner};
use supple::internal::gpu::{Sources, modules};
use supple::material::Material;

/// Whether there is an array in a value of this type.
fn holds_array(module: &Module, ty: Handle<Type>) -> bool {
    match &module.types[ty].inner {
        TypeInner::Array { .. } => true,
        TypeInner::Struct { members, .. } => members.iter().any(|m| holds_array(module, m.ty)),
        _ => false,
    }
}

/// Whether a value of this type, or what it points to in a function, is an array in something.
fn is_nested(module: &Module, ty: Handle<Type>) -> bool {
    match &module.types[ty].inner {
        TypeInner::Array { base, .. } => holds_array(module, *base),
        TypeInner::Struct { .. } => holds_array(module, ty),
        TypeInner::Pointer {
            base,
            space: AddressSpace::Function | AddressSpace::Private,
        } => is_nested(module, *base),
        _ => false,
    }
}

/// The variables, arguments and results of `module` that FXC would stumble over.
fn nested_arrays(module: &Module) -> Vec<String> {
    let mut out = Vec::new();
    let mut note = |function: &str, name: &Option<String>, ty: Handle<Type>| {
        if is_nested(module, ty) {
            out.push(format!(
                "{function}: {}",
                name.as_deref().unwrap_or("its result")
            ));
        }
    };
    let entries = module.entry_points.iter().map(|e| &e.function);
    for function in module.functions.iter().map(|(_, f)| f).chain(entries) {
        let name = function.name.as_deref().unwrap_or("an entry point");
        for argument in &function.arguments {
            note(name, &argument.name, argument.ty);
        }
        for (_, variable) in function.local_variables.iter() {
            note(name, &variable.name, variable.ty);
        }
        if let Some(result) = &function.result {
            note(name, &None, result.ty);
        }
    }
    for (_, global) in module.global_variables.iter() {
        if global.space == AddressSpace::Private {
            note("the module", &global.name, global.ty);
        }
    }
    out
}

fn all_nested(sources: &Sources) -> Vec<String> {
    let modules = modules(sources).unwrap();
    modules
        .iter()
        .flat_map(|m| nested_arrays(m.parsed()))
        .collect()
}

#[test]
fn no_kernel_has_an_array_in_something_in_a_function() {
    for material in Material::examples() {
        assert_eq!(all_nested(&Sources::new(&material)), Vec::<String>::new());
    }
}

#[test]
fn arrays_in_arrays_and_in_structs_are_noticed() {
    let orthotropic = |m: &Material| m.kernels().contains(&"material/orthotropic.wgsl");
    let material = Material::examples().into_iter().find(orthotropic).unwrap();
    for (from, to) in [
        (
            "var b: array<mat3x3<f32>, 9>;",
            "var b: array<mat3x3<f32>, 9>; var c: array<array<f32, 2>, 2>;",
        ),
        ("struct Fibres {", "struct Fibres { rows: array<f32, 2>,"),
        (
            "fn fibre_moduli()",
            "var<private> kept: array<array<f32, 3>, 3>;\nfn fibre_moduli()",
        ),
        (
            "fn fibre_moduli()",
            "fn first(m: ptr<function, array<array<f32, 3>, 3>>) -> f32 { return (*m)[0][0]; }\nfn fibre_moduli()",
        ),
    ] {
        let sources = Sources::new(&material).edited("material/orthotropic.wgsl", from, to);
        let sources = sources.and_then(|s| {
            s.edited(
                "material/orthotropic.wgsl",
                "return Fibres(",
                "return Fibres(FILL",
            )
        });
        let fill = if to.contains("rows") {
            "array<f32, 2>(), "
        } else {
            ""
        };
        let sources = sources.and_then(|s| s.edited("material/orthotropic.wgsl", "FILL", fill));
        assert!(!all_nested(&sources.unwrap()).is_empty(), "{to}");
    }
}
