//! Pickles for tests, put together from pieces; Python 2 writes its texts and bytes as one thing.

/// Who writes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Python {
    /// Protocol 2 of Python 2.
    Two,
    /// Protocol 4 of Python 3.
    Three,
}
use Python::{Three, Two};

impl Python {
    pub fn program(self, body: &[u8]) -> Vec<u8> {
        let protocol = if self == Two { 2 } else { 4 };
        [&[0x80, protocol], body, b"."].concat()
    }

    pub fn text(self, text: &str) -> Vec<u8> {
        let opcode = if self == Two { b'T' } else { b'X' };
        counted(opcode, text.as_bytes())
    }

    pub fn bytes(self, bytes: &[u8]) -> Vec<u8> {
        counted(if self == Two { b'T' } else { b'B' }, bytes)
    }

    pub fn class(self, module: &str, name: &str) -> Vec<u8> {
        match self {
            Two => format!("c{module}\n{name}\n").into_bytes(),
            Three => [self.text(module), self.text(name), vec![0x93]].concat(),
        }
    }

    pub fn call(self, module: &str, name: &str, arguments: &[Vec<u8>]) -> Vec<u8> {
        [self.class(module, name), tuple(arguments), b"R".to_vec()].concat()
    }

    pub fn dict(self, entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let pair = |(key, value): &(&str, Vec<u8>)| [self.text(key), value.clone()].concat();
        let pairs: Vec<_> = entries.iter().flat_map(pair).collect();
        [b"}(".to_vec(), pairs, b"u".to_vec()].concat()
    }

    /// An object of a class with its state.
    pub fn object(self, module: &str, name: &str, state: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let made = match self {
            Two => {
                let object = self.class("__builtin__", "object");
                let arguments = [self.class(module, name), object, b"N".to_vec()];
                self.call("copy_reg", "_reconstructor", &arguments)
            }
            Three => [self.class(module, name), tuple(&[]), vec![0x81]].concat(),
        };
        build(made, self.dict(state))
    }

    pub fn element_type(self, descr: &str) -> Vec<u8> {
        let (order, code) = descr.split_at(1);
        let made = self.call("numpy", "dtype", &[self.text(code), int(0), int(1)]);
        let none = b"N".to_vec();
        let state = [
            int(3),
            self.text(order),
            none.clone(),
            none.clone(),
            none,
            int(-1),
            int(-1),
            int(0),
        ];
        build(made, tuple(&state))
    }

    pub fn array(self, descr: &str, shape: &[usize], fortran: bool, data: &[u8]) -> Vec<u8> {
        let core = if self == Two {
            "numpy.core"
        } else {
            "numpy._core"
        };
        let class = self.class("numpy", "ndarray");
        let arguments = [class, tuple(&[int(0)]), self.bytes(b"b")];
        let made = self.call(&format!("{core}.multiarray"), "_reconstruct", &arguments);
        let lengths: Vec<_> = shape.iter().map(|n| int(*n as i32)).collect();
        let order = vec![if fortran { 0x88 } else { 0x89 }];
        let state = [
            int(1),
            tuple(&lengths),
            self.element_type(descr),
            order,
            self.bytes(data),
        ];
        build(made, tuple(&state))
    }

    pub fn f64s(self, shape: &[usize], values: &[f64]) -> Vec<u8> {
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.array("<f8", shape, false, &data)
    }

    pub fn u32s(self, shape: &[usize], values: &[u32]) -> Vec<u8> {
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.array("<u4", shape, false, &data)
    }
}

fn counted(opcode: u8, bytes: &[u8]) -> Vec<u8> {
    [&[opcode], &(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}

pub(crate) fn int(value: i32) -> Vec<u8> {
    [&b"J"[..], &value.to_le_bytes()].concat()
}

pub(crate) fn tuple(items: &[Vec<u8>]) -> Vec<u8> {
    [b"(".to_vec(), items.concat(), b"t".to_vec()].concat()
}

pub(crate) fn build(object: Vec<u8>, state: Vec<u8>) -> Vec<u8> {
    [object, state, b"b".to_vec()].concat()
}
