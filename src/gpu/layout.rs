//! Structs that the host and the kernels share, and where the compiler of the kernels puts their fields.

/// A `repr(C)` struct with a twin of the same name in WGSL.
pub trait HostShareable: bytemuck::Pod {
    /// Where Rust puts it. Fields that only pad (their names begin with `_`) are left out.
    const LAYOUT: StructLayout<'static>;
}

/// Size, and name and offset of every field, in bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StructLayout<'a> {
    /// Name of the struct.
    pub name: &'a str,
    /// Size of one item of an array of it.
    pub size: usize,
    /// Fields in order.
    pub fields: &'a [(&'a str, usize)],
}

/// A [`HostShareable`] whose type is known at run time only.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SharedValue {
    /// Where its fields are.
    pub layout: StructLayout<'static>,
    /// What the kernels read.
    pub bytes: Vec<u8>,
}

impl<T: HostShareable> From<T> for SharedValue {
    fn from(value: T) -> Self {
        Self {
            layout: T::LAYOUT,
            bytes: bytemuck::bytes_of(&value).to_vec(),
        }
    }
}

/// Declares structs shared with the kernels: `repr(C)`, plain data, layout known.
macro_rules! host_shareable {
    ($($(#[$doc:meta])* pub struct $name:ident { $($(#[$field_doc:meta])* pub $field:ident: $type:ty,)* })*) => {$(
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_doc])* pub $field: $type,)* }

        impl $crate::gpu::HostShareable for $name {
            const LAYOUT: $crate::gpu::StructLayout<'static> = $crate::gpu::StructLayout {
                name: stringify!($name),
                size: size_of::<$name>(),
                fields: &[$((stringify!($field), std::mem::offset_of!($name, $field)),)*],
            };
        }
    )*};
}
pub(crate) use host_shareable;
