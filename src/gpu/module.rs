//! Compute kernels in WGSL, parsed and validated.

use crate::{GpuError, Result};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, GlobalVariable};

/// A parsed and validated WGSL module.
#[derive(Debug)]
pub struct Module {
    pub(super) name: String,
    pub(super) source: String,
    pub(super) module: naga::Module,
    info: ModuleInfo,
}

impl Module {
    /// Parses and validates `source`; needs no device.
    ///
    /// # Errors
    /// [`GpuError::Shader`] with the compiler's message and the line.
    pub fn parse(name: &str, source: String) -> Result<Self> {
        let fail = |message: String| GpuError::Shader {
            kernel: name.to_owned(),
            message,
        };
        let module = naga::front::wgsl::parse_str(&source)
            .map_err(|e| fail(e.emit_to_string_with_path(&source, name)))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .map_err(|e| fail(e.emit_to_string_with_path(&source, name)))?;
        Ok(Self {
            name: name.to_owned(),
            source,
            module,
            info,
        })
    }

    /// What the compiler's front made of it.
    pub fn parsed(&self) -> &naga::Module {
        &self.module
    }

    /// Names of the entry points.
    pub fn entry_points(&self) -> impl Iterator<Item = &str> {
        self.module.entry_points.iter().map(|e| e.name.as_str())
    }

    /// Size and field offsets of the struct `name` as the kernel sees it.
    pub fn struct_layout(&self, name: &str) -> Option<(usize, Vec<(String, usize)>)> {
        self.module
            .types
            .iter()
            .find_map(|(_, ty)| match &ty.inner {
                naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some(name) => {
                    let fields = members
                        .iter()
                        .map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize));
                    Some((*span as usize, fields.collect()))
                }
                _ => None,
            })
    }

    /// Names of the structs the module declares.
    pub fn structs(&self) -> impl Iterator<Item = &str> {
        self.module.types.iter().filter_map(|(_, ty)| {
            matches!(ty.inner, naga::TypeInner::Struct { .. }).then_some(ty.name.as_deref()?)
        })
    }

    /// The buffers that entry point `entry` uses.
    pub(super) fn globals(&self, entry: usize) -> impl Iterator<Item = &GlobalVariable> {
        let usage = self.info.get_entry_point(entry);
        self.module
            .global_variables
            .iter()
            .filter(move |(handle, global)| global.binding.is_some() && !usage[*handle].is_empty())
            .map(|(_, global)| global)
    }

    /// Number of storage buffers that entry point `entry` uses.
    pub fn storage_buffers(&self, entry: &str) -> Option<usize> {
        let index = self
            .module
            .entry_points
            .iter()
            .position(|e| e.name == entry)?;
        Some(
            self.globals(index)
                .filter(|g| matches!(g.space, AddressSpace::Storage { .. }))
                .count(),
        )
    }
}
