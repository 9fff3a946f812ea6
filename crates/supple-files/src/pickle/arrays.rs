//! Nodes to arrays: NumPy's objects, plain numbers, texts and lists of them.

use super::globals::Global;
use super::text::to_latin1;
use super::{DEEPEST, Node, Pickle, Value};
use crate::array::{Array, ElementType, MOST_TEXTS};
use crate::arrays::Item;
use std::borrow::Cow;

impl Pickle<'_> {
    /// What `value` holds as an array of at most `room` numbers.
    pub(super) fn item(&self, value: Value, room: usize) -> Result<Item, String> {
        match self.sparse(value, room)? {
            Some(matrix) => Ok(Item::Sparse(matrix)),
            None => match self.inner_object(value) {
                Some(inner) => self.item_inside(inner, room),
                None => self.array(value, room, DEEPEST).map(Item::Dense),
            },
        }
    }

    /// What a single object in an array of objects is.
    fn item_inside(&self, value: Value, room: usize) -> Result<Item, String> {
        match self.sparse(value, room)? {
            Some(matrix) => Ok(Item::Sparse(matrix)),
            None => self.array(value, room, DEEPEST).map(Item::Dense),
        }
    }

    /// `value` as a dense array, `depth` nodes deep at most.
    pub(super) fn array(&self, value: Value, room: usize, depth: usize) -> Result<Array, String> {
        let deeper = depth.checked_sub(1).ok_or("is nested too deeply")?;
        if let Some(number) = plain_number(value) {
            return Ok(Array {
                numbers: vec![number],
                ..Array::default()
            });
        }
        if let Some(text) = self.text(value) {
            return Ok(Array {
                texts: vec![text.into_owned()],
                ..Array::default()
            });
        }
        if let Some(items) = self.sequence(value) {
            return self.list(items, room);
        }
        let not_read = || Err(format!("is {}, not an array", self.name(value)));
        let Some((class, arguments, state)) = self.call(value) else {
            return not_read();
        };
        match class {
            Global::NumpyArray => self.numpy_array(state, room, deeper),
            Global::NumpyFromBuffer => {
                let Some(&[buffer, element, shape, order]) = self.sequence(arguments) else {
                    return Err("an array from a buffer needs bytes, type, shape, order".into());
                };
                let fortran = self.text(order).is_some_and(|o| o == "F");
                self.decode(buffer, element, shape, fortran, room)
            }
            Global::NumpyScalar => match self.sequence(arguments) {
                Some(&[element, bytes]) => self.decode_shape(bytes, element, &[], false, room),
                _ => Err("a number of NumPy's needs a type and bytes".into()),
            },
            Global::Chumpy | Global::ChumpySelect | Global::ChumpyReshape => {
                self.chumpy(class, state, room, deeper)
            }
            Global::ChumpyOther => Err(format!(
                "is {}, an expression that is not evaluated: save its value (its .r)",
                self.name(value)
            )),
            _ => not_read(),
        }
    }

    /// NumPy's state: version, shape, type, whether the first index runs fastest, bytes.
    fn numpy_array(&self, state: Value, room: usize, depth: usize) -> Result<Array, String> {
        let Some(&[_, shape, element, fortran, data]) = self.sequence(state) else {
            return Err("an array's state is not NumPy's".into());
        };
        // An array of objects holds a list.
        if let Some(items) = self.sequence(data) {
            return match *items {
                [inner] if self.sequence(shape).is_some_and(<[_]>::is_empty) => {
                    self.array(inner, room, depth)
                }
                _ => self.list(items, room),
            };
        }
        self.decode(data, element, shape, self.int(fortran) == Some(1), room)
    }

    /// The object in an array of objects that has no dimension.
    fn inner_object(&self, value: Value) -> Option<Value> {
        let (Global::NumpyArray, _, state) = self.call(value)? else {
            return None;
        };
        let &[_, shape, _, _, data] = self.sequence(state)? else {
            return None;
        };
        match (self.sequence(shape)?, self.sequence(data)?) {
            ([], &[inner]) => Some(inner),
            _ => None,
        }
    }

    fn decode(
        &self,
        data: Value,
        element: Value,
        shape: Value,
        fortran: bool,
        room: usize,
    ) -> Result<Array, String> {
        let shape = self.shape(shape)?;
        self.decode_shape(data, element, &shape, fortran, room)
    }

    fn decode_shape(
        &self,
        data: Value,
        element: Value,
        shape: &[usize],
        fortran: bool,
        room: usize,
    ) -> Result<Array, String> {
        let element = self.element_type(element)?;
        let count = shape
            .iter()
            .fold(element.size, |n, length| n.saturating_mul(*length));
        let bytes = self.bytes(data, count, DEEPEST)?;
        Array::from_bytes(&element, shape, fortran, &bytes, room)
    }

    /// A number of Python's or NumPy's.
    fn number(&self, value: Value) -> Option<f64> {
        let scalar = || match self.call(value)? {
            (Global::NumpyScalar, ..) => self.array(value, 1, 1).ok()?.numbers.first().copied(),
            _ => None,
        };
        plain_number(value).or_else(scalar)
    }

    /// A tuple of lengths, or one length.
    pub(super) fn shape(&self, value: Value) -> Result<Vec<usize>, String> {
        let length = |v: &Value| {
            let length = self.number(*v).filter(|n| n.fract() == 0.0);
            length
                .filter(|n| (0.0..9e15).contains(n))
                .map(|n| n as usize)
        };
        let lengths = match self.sequence(value) {
            Some(lengths) => lengths.iter().map(length).collect(),
            None => length(&value).map(|n| vec![n]),
        };
        lengths.ok_or_else(|| "a shape must hold lengths".into())
    }

    /// `numpy.dtype('f8', …)` with the byte order in its state: version, order, ….
    fn element_type(&self, value: Value) -> Result<ElementType, String> {
        let Some((Global::NumpyType, arguments, state)) = self.call(value) else {
            return Err("an array's type is no numpy.dtype".into());
        };
        let first = self.sequence(arguments).and_then(|a| a.first());
        let code = first.and_then(|c| self.text(*c));
        let order = self.sequence(state).and_then(|s| s.get(1));
        let order = order.and_then(|o| self.text(*o));
        let code = code.ok_or("an array's type has no name")?;
        ElementType::parse(&format!("{}{code}", order.as_deref().unwrap_or("<")))
    }

    /// So many bytes, however they are wrapped.
    fn bytes(&self, value: Value, count: usize, depth: usize) -> Result<Cow<'_, [u8]>, String> {
        let deeper = depth.checked_sub(1).ok_or("is nested too deeply")?;
        match self.node(value) {
            Some(Node::Bytes(bytes)) => return Ok(Cow::Borrowed(bytes)),
            // A byte takes two in UTF-8 at most; what is longer is not worth decoding.
            Some(Node::Text(text)) if text.len() / 2 > count => {
                return Err(format!("a text stands where {count} bytes should"));
            }
            Some(Node::Text(text)) => return to_latin1(text),
            _ => {}
        }
        if let Some((Global::Encode | Global::Bytes, arguments, _)) = self.call(value) {
            match self.sequence(arguments) {
                // Of `encode`, only Latin-1 is ever written.
                Some([inner]) => return self.bytes(*inner, count, deeper),
                Some([inner, encoding]) if self.text(*encoding).is_some_and(|e| latin1(&e)) => {
                    return self.bytes(*inner, count, deeper);
                }
                Some([]) => return Ok(Cow::Borrowed(&[])),
                _ => {}
            }
        }
        Err(format!("{} stands where bytes should", self.name(value)))
    }

    /// A list of numbers or of texts.
    fn list(&self, items: &[Value], room: usize) -> Result<Array, String> {
        let mut array = Array {
            shape: vec![items.len()],
            ..Array::default()
        };
        if items.len() > room {
            return Err("holds more numbers than are read".into());
        }
        let numbers: Option<Vec<f64>> = items.iter().map(|v| self.number(*v)).collect();
        if let Some(numbers) = numbers {
            array.numbers = numbers;
            return Ok(array);
        }
        if items.len() <= MOST_TEXTS {
            let text = |v: &Value| self.text(*v).map(Cow::into_owned);
            if let Some(texts) = items.iter().map(text).collect() {
                array.texts = texts;
                return Ok(array);
            }
        }
        Err("is a list of neither numbers nor short texts".into())
    }
}

fn latin1(encoding: &str) -> bool {
    matches!(encoding, "latin1" | "latin-1" | "iso-8859-1")
}

fn plain_number(value: Value) -> Option<f64> {
    match value {
        Value::Int(int) => Some(int as f64),
        Value::Float(float) => Some(float),
        Value::Bool(bit) => Some(f64::from(u8::from(bit))),
        Value::None | Value::Node(_) => None,
    }
}
