//! Arrays as NumPy stores them: a shape, an element type, bytes.

use supple::internal::math::Rows;

/// Most numbers that one file's arrays may hold together: 1 GiB of f64.
pub(crate) const MOST_NUMBERS: usize = 1 << 27;

/// Most texts of an array: more than any body has bones.
pub(crate) const MOST_TEXTS: usize = 1 << 16;

/// An array of numbers or of texts, in C order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Array {
    pub shape: Vec<usize>,
    pub numbers: Vec<f64>,
    pub texts: Vec<String>,
}

/// A matrix of which only some elements are stored; those of one place add up.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SparseMatrix {
    /// Column and value of what is stored, row after row.
    pub rows: Rows<(u32, f64)>,
    pub columns: usize,
}

impl Array {
    /// The array of this `shape` that lies in `data`; at most `room` numbers.
    pub fn from_bytes(
        element: &ElementType,
        shape: &[usize],
        fortran: bool,
        data: &[u8],
        room: usize,
    ) -> Result<Self, String> {
        let count = shape
            .iter()
            .try_fold(1usize, |product, n| product.checked_mul(*n));
        if count.and_then(|c| c.checked_mul(element.size)) != Some(data.len()) {
            return Err(format!(
                "{} bytes of data do not fill shape {shape:?} of {element}",
                data.len()
            ));
        }
        let most = if element.is_text() { MOST_TEXTS } else { room };
        if data.len() / element.size.max(1) > most {
            return Err(format!("shape {shape:?} is more than is read"));
        }
        let mut array = Self {
            shape: shape.to_vec(),
            ..Self::default()
        };
        let items = data.chunks_exact(element.size.max(1));
        if element.is_text() {
            array.texts = items.map(|item| element.text(item)).collect();
        } else {
            array.numbers = items.map(|item| element.number(item)).collect();
        }
        if fortran && shape.len() > 1 {
            array.texts = from_fortran(shape, &array.texts);
            array.numbers = from_fortran(shape, &array.numbers);
        }
        Ok(array)
    }
}

/// What one element is: NumPy's type string, taken apart.
pub(crate) struct ElementType {
    big_endian: bool,
    letter: char,
    /// Bytes of one element.
    pub size: usize,
}

impl ElementType {
    /// Reads a type string such as `<f8`.
    pub fn parse(descr: &str) -> Result<Self, String> {
        let unknown = || {
            let shown: String = descr.chars().take(20).collect();
            format!("type {shown:?} is not read; save f4, f8, integers or U")
        };
        let mut chars = descr.chars();
        let order = chars.next().ok_or_else(unknown)?;
        let letter = chars.next().ok_or_else(unknown)?;
        let size: usize = chars.as_str().parse().map_err(|_| unknown())?;
        let known = match letter {
            'f' => matches!(size, 4 | 8),
            'i' | 'u' => matches!(size, 1 | 2 | 4 | 8),
            'b' => size == 1,
            'U' | 'S' => (1..=1024).contains(&size),
            _ => false,
        };
        if !known || !matches!(order, '<' | '>' | '|' | '=') {
            return Err(unknown());
        }
        Ok(Self {
            big_endian: order == '>',
            letter,
            size: if letter == 'U' { 4 * size } else { size },
        })
    }

    fn is_text(&self) -> bool {
        matches!(self.letter, 'U' | 'S')
    }

    /// The element as an integer's bits, lowest byte first.
    fn bits(&self, item: &[u8]) -> u64 {
        let join = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        if self.big_endian {
            item.iter().fold(0, join)
        } else {
            item.iter().rev().fold(0, join)
        }
    }

    fn number(&self, item: &[u8]) -> f64 {
        let bits = self.bits(item);
        let unused = 64 - 8 * self.size as u32;
        match (self.letter, self.size) {
            ('f', 4) => f64::from(f32::from_bits(bits as u32)),
            ('f', _) => f64::from_bits(bits),
            // Shifted up and down again, the sign fills the unused bits.
            ('i', _) => ((bits << unused) as i64 >> unused) as f64,
            _ => bits as f64,
        }
    }

    /// Characters up to the first 0: four bytes each, or one (Latin-1) in `S`.
    fn text(&self, item: &[u8]) -> String {
        let width = if self.letter == 'U' { 4 } else { 1 };
        item.chunks_exact(width)
            .map(|c| self.bits(c) as u32)
            .take_while(|c| *c != 0)
            .map(|c| char::from_u32(c).unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect()
    }
}

impl std::fmt::Display for ElementType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let order = if self.big_endian { '>' } else { '<' };
        let size = if self.letter == 'U' {
            self.size / 4
        } else {
            self.size
        };
        write!(f, "{order}{}{size}", self.letter)
    }
}

/// Reorders items whose first index runs fastest so that the last one does.
fn from_fortran<T: Clone>(shape: &[usize], items: &[T]) -> Vec<T> {
    let mut index = vec![0; shape.len()];
    let mut strides = vec![1; shape.len()];
    for k in 1..shape.len() {
        strides[k] = strides[k - 1] * shape[k - 1];
    }
    (0..items.len())
        .map(|_| {
            let at: usize = index.iter().zip(&strides).map(|(i, s)| i * s).sum();
            for k in (0..shape.len()).rev() {
                index[k] += 1;
                if index[k] < shape[k] {
                    break;
                }
                index[k] = 0;
            }
            items[at].clone()
        })
        .collect()
}
