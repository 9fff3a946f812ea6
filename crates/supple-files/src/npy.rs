//! NumPy's array format, `.npy`.
//!
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>. Read here because sizes must be
//! checked before anything is multiplied or allocated.

use super::array::{Array, ElementType};
use super::arrays::Item;
use super::pickle;

const MAGIC: &[u8; 6] = b"\x93NUMPY";

/// Reads one `.npy` file of at most `room` numbers; the error says what is wrong.
pub(crate) fn parse(bytes: &[u8], room: usize) -> Result<Item, String> {
    let short = || "ends within its header".to_string();
    if bytes.get(..6) != Some(MAGIC) {
        return Err("is no .npy array".into());
    }
    let (start, length) = match *bytes.get(6).ok_or_else(short)? {
        1 => (
            10,
            bytes
                .get(8..10)
                .map(|b| u64::from(b[0]) | u64::from(b[1]) << 8),
        ),
        2 | 3 => (
            12,
            bytes
                .get(8..12)
                .map(|b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
        ),
        version => return Err(format!("version {version} of .npy is not known")),
    };
    let end = usize::try_from(length.ok_or_else(short)?)
        .ok()
        .and_then(|l| l.checked_add(start))
        .ok_or_else(short)?;
    let header = bytes.get(start..end).ok_or_else(short)?;
    let header = std::str::from_utf8(header).map_err(|_| "its header is no text".to_string())?;
    let entry = |key: &str| {
        let quoted = format!("'{key}':");
        let at = header.find(&quoted);
        at.map(|i| header[i + quoted.len()..].trim_start())
            .ok_or_else(|| format!("its header has no {key}"))
    };
    let descr: String = entry("descr")?
        .strip_prefix('\'')
        .map(|d| d.chars().take_while(|c| *c != '\'').collect())
        .ok_or("structured arrays are not read; save plain numbers")?;
    let fortran = entry("fortran_order")?.starts_with("True");
    let shape: Vec<usize> = entry("shape")?
        .trim_start_matches('(')
        .split(')')
        .next()
        .unwrap_or("")
        .split(',')
        .filter(|s| !s.trim().is_empty())
        .map(|s| {
            s.trim()
                .parse()
                .map_err(|_| format!("its shape holds {s:?}"))
        })
        .collect::<Result<_, _>>()?;
    let data = &bytes[end..];
    if descr == "|O" {
        return pickle::parse_array(data, room);
    }
    let element = ElementType::parse(&descr)?;
    Array::from_bytes(&element, &shape, fortran, data, room).map(Item::Dense)
}

/// The bytes of an `.npy` file: header of version 1.0, data in C order.
fn encode(descr: &str, shape: &[usize], data: &[u8]) -> Vec<u8> {
    let sizes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({sizes}), }}");
    // Data start at a multiple of 64 bytes, as NumPy writes them.
    let padding = (64 - (10 + header.len() + 1) % 64) % 64;
    header.push_str(&" ".repeat(padding));
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

/// An array of f64.
pub(crate) fn encode_f64(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    encode("<f8", shape, &data)
}

/// An array of u32.
pub(crate) fn encode_u32(shape: &[usize], values: &[u32]) -> Vec<u8> {
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    encode("<u4", shape, &data)
}

/// A one-dimensional array of texts.
pub(crate) fn encode_texts(values: &[String]) -> Vec<u8> {
    let length = values
        .iter()
        .map(|t| t.chars().count())
        .max()
        .unwrap_or(0)
        .max(1);
    let pad = |t: &String| {
        let codes = t.chars().map(u32::from).chain(std::iter::repeat(0));
        codes.take(length).collect::<Vec<_>>()
    };
    let data: Vec<u8> = values
        .iter()
        .flat_map(pad)
        .flat_map(u32::to_le_bytes)
        .collect();
    encode(&format!("<U{length}"), &[values.len()], &data)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(bytes: &[u8]) -> Result<Array, String> {
        match super::parse(bytes, 1 << 20)? {
            Item::Dense(array) => Ok(array),
            Item::Sparse(_) => Err("sparse".into()),
        }
    }

    fn file(descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}}}\n");
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn numbers_of_every_kind_are_read() {
        let read = |descr: &str, data: &[u8]| {
            parse(&file(&format!("'{descr}'"), "False", "(1,)", data))
                .unwrap()
                .numbers[0]
        };
        assert_eq!(read("<f4", &1.5f32.to_le_bytes()), 1.5);
        assert_eq!(read(">f8", &(-2.25f64).to_be_bytes()), -2.25);
        assert_eq!(read("|i1", &[0xff]), -1.0);
        assert_eq!(read("<i8", &(-7i64).to_le_bytes()), -7.0);
        assert_eq!(read("<u4", &u32::MAX.to_le_bytes()), 4294967295.0);
        assert_eq!(read(">u2", &[1, 2]), 258.0);
    }

    #[test]
    fn fortran_order_is_turned_round() {
        let data: Vec<u8> = (0..6u8).collect();
        let c = parse(&file("'|u1'", "False", "(2, 3)", &data)).unwrap();
        let f = parse(&file("'|u1'", "True", "(2, 3)", &data)).unwrap();
        assert_eq!(c.numbers, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(f.numbers, [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
    }

    #[test]
    fn impossible_headers_are_refused() {
        let refused = |bytes: Vec<u8>, hint: &str| {
            let e = parse(&bytes).unwrap_err();
            assert!(e.contains(hint), "{e}");
        };
        refused(
            file("'<f8'", "False", "(9999999999, 9999999999, 4)", &[0; 8]),
            "do not fill",
        );
        refused(file("'<f8'", "False", "(2,)", &[0; 8]), "do not fill");
        refused(
            file("'|O'", "False", "(1,)", b"I1\n"),
            "bytes are announced",
        );
        refused(file("'<c8'", "False", "(1,)", &[0; 8]), "not read");
        refused(
            file("[('x', '<f8')]", "False", "(1,)", &[0; 8]),
            "structured",
        );
        refused(file("'<f8'", "False", "(-1,)", &[0; 8]), "shape");
        refused(b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec(), "header");
        refused(vec![], "no .npy");
    }

    #[test]
    fn what_is_written_is_read() {
        let values = [0.1, -3.0, f64::MIN_POSITIVE, 4.0, 5.5, 1e300];
        let array = parse(&encode_f64(&[2, 3], &values)).unwrap();
        assert_eq!((array.shape, array.numbers), (vec![2, 3], values.to_vec()));
        let texts = ["index1".to_string(), "µ".to_string(), String::new()];
        let array = parse(&encode_texts(&texts)).unwrap();
        assert_eq!((array.shape, array.texts), (vec![3], texts.to_vec()));
        assert_eq!(encode_u32(&[1], &[7]).len() % 64, 4);
    }
}
