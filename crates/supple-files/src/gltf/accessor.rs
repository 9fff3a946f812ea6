//! Numbers out of accessors, every bound checked first (glTF 2.0, §3.6.2).

use super::compression::DracoMesh;
use super::container::File;
use super::document::{Accessor, Primitive, SparseArray};
use supple::Result;

/// What is wrong with an accessor.
type Problem = String;

/// One number of a buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn new(code: u32) -> Result<Self, Problem> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(format!("componentType {code} is none of glTF's")),
        })
    }

    fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number in `bytes`, as many as its size; missing ones are 0.
    fn decode(self, bytes: &[u8]) -> f64 {
        let byte = |k: usize| bytes.get(k).copied().unwrap_or(0);
        let short = [byte(0), byte(1)];
        let long = [byte(0), byte(1), byte(2), byte(3)];
        match self {
            Self::I8 => f64::from(byte(0) as i8),
            Self::U8 => f64::from(byte(0)),
            Self::I16 => f64::from(i16::from_le_bytes(short)),
            Self::U16 => f64::from(u16::from_le_bytes(short)),
            Self::U32 => f64::from(u32::from_le_bytes(long)),
            Self::F32 => f64::from(f32::from_le_bytes(long)),
        }
    }

    /// A normalised integer as the number it stands for (§3.6.2.2).
    fn normalised(self, value: f64) -> Result<f64, Problem> {
        match self {
            Self::I8 => Ok((value / 127.0).max(-1.0)),
            Self::U8 => Ok(value / 255.0),
            Self::I16 => Ok((value / 32767.0).max(-1.0)),
            Self::U16 => Ok(value / 65535.0),
            Self::U32 | Self::F32 => Err("32-bit components cannot be normalised".into()),
        }
    }
}

impl File {
    /// The elements of an accessor of `N` components each: 1 SCALAR, 2 VEC2, 3 VEC3, 4 VEC4, 16 MAT4.
    /// All are finite.
    pub fn vectors<const N: usize>(&self, accessor: usize) -> Result<Vec<[f64; N]>> {
        let field = || format!("accessors[{accessor}]");
        let found = (self.document.accessors.get(accessor))
            .ok_or_else(|| self.broken(field(), "is not there"))?;
        let numbers = self.numbers(found, N);
        let numbers = numbers.map_err(|problem| self.broken(field(), problem))?;
        Ok(numbers.as_chunks().0.to_vec())
    }

    /// The elements of a SCALAR accessor of whole numbers, each below `bound`.
    pub fn indices(&self, accessor: usize, bound: usize) -> Result<Vec<u32>> {
        let index = |[v]: &[f64; 1]| {
            if *v >= 0.0 && *v < bound as f64 && v.fract() == 0.0 {
                Ok(*v as u32)
            } else {
                let problem = format!("names vertex {v} of {bound}");
                Err(self.broken(format!("accessors[{accessor}]"), problem))
            }
        };
        self.vectors::<1>(accessor)?.iter().map(index).collect()
    }

    /// What a primitive's Draco data become, or nothing where it has none that this build reads and it does without.
    pub fn draco(&self, primitive: &Primitive) -> Result<Option<DracoMesh>, Problem> {
        let Some(draco) = &primitive.extensions.draco else {
            return Ok(None);
        };
        if !cfg!(feature = "draco") && !self.requires("KHR_draco_mesh_compression") {
            return Ok(None);
        }
        let mesh = DracoMesh::new(self.view(draco.buffer_view)?, self.budget.get())?;
        self.spend(mesh.points() as u64)?;
        Ok(Some(mesh))
    }

    /// An attribute of a Draco mesh, as the accessor of that attribute says what its numbers are.
    pub fn draco_vectors<const N: usize>(
        &self,
        mesh: &DracoMesh,
        id: u32,
        accessor: &Accessor,
    ) -> Result<Vec<[f64; N]>, Problem> {
        self.spend((mesh.points() as u64).saturating_mul(N as u64))?;
        let mut numbers = mesh.attribute(id, N)?;
        if accessor.normalized {
            let component = Component::new(accessor.component_type)?;
            for v in &mut numbers {
                *v = component.normalised(*v)?;
            }
        }
        Ok(numbers.as_chunks().0.to_vec())
    }

    fn numbers(&self, accessor: &Accessor, width: usize) -> Result<Vec<f64>, Problem> {
        let kind = match width {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        if accessor.kind != kind {
            return Err(format!("is {}, {kind} is needed", accessor.kind));
        }
        let component = Component::new(accessor.component_type)?;
        let numbers = accessor.count.saturating_mul(width as u64);
        self.spend(numbers)?;
        let mut out = match accessor.buffer_view {
            None => vec![0.0; numbers as usize],
            Some(view) => {
                let offset = accessor.byte_offset;
                self.elements(view, offset, component, width, accessor.count)?
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let SparseArray {
                buffer_view,
                byte_offset,
                component_type,
            } = sparse.indices;
            let whole = Component::new(component_type.unwrap_or(0))
                .map_err(|e| format!("sparse indices: {e}"))?;
            let places = self.elements(buffer_view, byte_offset, whole, 1, sparse.count)?;
            let SparseArray {
                buffer_view,
                byte_offset,
                ..
            } = sparse.values;
            self.spend(sparse.count.saturating_mul(width as u64))?;
            let values = self.elements(buffer_view, byte_offset, component, width, sparse.count)?;
            for (place, value) in places.iter().zip(values.chunks_exact(width)) {
                if !(*place >= 0.0 && *place < accessor.count as f64 && place.fract() == 0.0) {
                    let problem = format!("sparse element {place} of {}", accessor.count);
                    return Err(problem);
                }
                let at = *place as usize * width;
                out[at..at + width].copy_from_slice(value);
            }
        }
        if accessor.normalized {
            for v in &mut out {
                *v = component.normalised(*v)?;
            }
        }
        match out.iter().all(|v| v.is_finite()) {
            true => Ok(out),
            false => Err("holds a value that is not finite".into()),
        }
    }

    /// `count` elements of `width` components from byte `offset` of a view.
    fn elements(
        &self,
        view: usize,
        offset: u64,
        component: Component,
        width: usize,
        count: u64,
    ) -> Result<Vec<f64>, Problem> {
        let bytes = self.view(view)?;
        let size = component.size() * width as u64;
        let stride = self.document.buffer_views[view].byte_stride.unwrap_or(size);
        if stride < size {
            return Err(format!("elements of {size} bytes every {stride}"));
        }
        // Last element's end: offset + (count − 1) stride + size.
        let end = (count.checked_sub(1))
            .map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size))
            .and_then(|length| length.checked_add(offset));
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let problem = format!(
                "{count} elements every {stride} bytes from byte {offset} do not fit in bufferViews[{view}] \
                 of {} bytes",
                bytes.len()
            );
            return Err(problem);
        }
        let mut out = Vec::with_capacity(count as usize * width);
        for element in 0..count {
            let at = (offset + element * stride) as usize;
            let element = &bytes[at..at + size as usize];
            let components = element.chunks_exact(component.size() as usize);
            out.extend(components.map(|bytes| component.decode(bytes)));
        }
        Ok(out)
    }

    /// Counts numbers that are about to be read.
    fn spend(&self, numbers: u64) -> Result<(), Problem> {
        match self.budget.get().checked_sub(numbers) {
            Some(rest) => {
                self.budget.set(rest);
                Ok(())
            }
            None => Err(
                "the accessors hold more numbers, all together, than a file of this size may"
                    .into(),
            ),
        }
    }
}
