//! Python's pickles, protocols 0 to 5, read as data: nothing is ever executed.
//!
//! <https://github.com/python/cpython/blob/main/Lib/pickletools.py> describes the opcodes. A pickle is a
//! program for a stack machine that may call any function of any module. Here the machine
//! ([`machine`]) knows only the names in [`globals`], and does not call them either: a call becomes a
//! node of what was called, with which arguments, and with which state. What a node stands for is
//! read afterwards, for the keys that are wanted ([`arrays`], [`sparse`], [`chumpy`]).
//!
//! Bounds: [`MOST_OPCODES`] opcodes, so at most as many nodes, stack and memo entries; byte strings are
//! slices of the file; a shared node is never copied, so references to references (memo bombs) cost
//! nothing; [`DEEPEST`] nodes within each other are followed where a value is read; arrays are decoded only
//! into the caller's room.

mod arrays;
mod calls;
mod chumpy;
mod globals;
mod input;
mod machine;
mod sparse;
mod stack;
mod text;

#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) mod writer;

use super::arrays::{Arrays, Item};
use globals::Global;
use std::borrow::Cow;
use std::path::Path;
use supple::{Error, Result};

/// Longest program that is run; a body model has some thousand opcodes.
const MOST_OPCODES: usize = 1 << 20;

/// Deepest nesting of nodes that is followed to a value.
const DEEPEST: usize = 6;

/// Longest text that is read as one, bytes.
const LONGEST_TEXT: usize = 1024;

/// A value of the machine. Everything that can hold others is a node, known by its index.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Value {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Node(u32),
}

/// What lies in the machine's memory.
#[derive(Debug)]
enum Node<'a> {
    Text(Cow<'a, str>),
    /// Bytes, or a text of Python 2.
    Bytes(Cow<'a, [u8]>),
    /// A list, tuple or set.
    Sequence(Vec<Value>),
    Dict(Vec<(Value, Value)>),
    Class(Global, String),
    /// `class(*arguments)`, with the state that was set on it.
    Call {
        class: u32,
        arguments: Value,
        state: Value,
    },
}

/// A pickle's nodes and its topmost value.
struct Pickle<'a> {
    nodes: Vec<Node<'a>>,
    root: Value,
}

impl<'a> Pickle<'a> {
    fn node(&self, value: Value) -> Option<&Node<'a>> {
        match value {
            Value::Node(index) => self.nodes.get(index as usize),
            _ => None,
        }
    }

    fn sequence(&self, value: Value) -> Option<&[Value]> {
        match self.node(value)? {
            Node::Sequence(items) => Some(items),
            _ => None,
        }
    }

    /// What class was called, with what arguments and state.
    fn call(&self, value: Value) -> Option<(Global, Value, Value)> {
        match self.node(value)? {
            Node::Call {
                class,
                arguments,
                state,
            } => match self.nodes.get(*class as usize)? {
                Node::Class(global, _) => Some((*global, *arguments, *state)),
                _ => None,
            },
            _ => None,
        }
    }

    /// A text, of either Python, if it is not longer than any name. (A long one that is shared
    /// would be decoded again and again.)
    fn text(&self, value: Value) -> Option<Cow<'_, str>> {
        match self.node(value)? {
            Node::Text(text) if text.len() <= LONGEST_TEXT => Some(Cow::Borrowed(text)),
            Node::Bytes(bytes) if bytes.len() <= LONGEST_TEXT => Some(text::from_latin1(bytes)),
            _ => None,
        }
    }

    fn int(&self, value: Value) -> Option<i64> {
        match value {
            Value::Int(int) => Some(int),
            Value::Bool(bit) => Some(i64::from(bit)),
            _ => None,
        }
    }

    /// The value of `key` in a dictionary or in an object's state; the last one, if it was set twice.
    fn get(&self, value: Value, key: &str) -> Option<Value> {
        let Node::Dict(entries) = self.node(value)? else {
            return None;
        };
        let found = entries.iter().rev();
        let mut found = found.filter(|(k, _)| match self.node(*k) {
            Some(Node::Text(text)) => text == key,
            Some(Node::Bytes(bytes)) => **bytes == *key.as_bytes(),
            _ => false,
        });
        found.next().map(|entry| entry.1)
    }

    /// How a value is called in errors.
    fn name(&self, value: Value) -> String {
        match (value, self.node(value)) {
            (Value::None, _) => "None".into(),
            (Value::Bool(_), _) => "a truth value".into(),
            (Value::Int(_), _) => "an integer".into(),
            (Value::Float(_), _) => "a number".into(),
            (_, Some(Node::Text(_))) => "a text".into(),
            (_, Some(Node::Bytes(_))) => "a byte string".into(),
            (_, Some(Node::Sequence(_))) => "a list".into(),
            (_, Some(Node::Dict(_))) => "a dictionary".into(),
            (_, Some(Node::Class(_, name))) => format!("the class {name}"),
            (_, Some(Node::Call { class, .. })) => match self.nodes.get(*class as usize) {
                Some(Node::Class(_, name)) => format!("an object of {name}"),
                _ => "an object".into(),
            },
            (_, None) => "nothing".into(),
        }
    }
}

/// Reads those of the `wanted` arrays that are in a pickled dictionary's `bytes`; `path` names it in errors.
///
/// # Errors
/// [`Error::Format`]: where the file is no pickle, names a class or function that is not on the list,
/// is beyond the bounds, is no dictionary, or holds something under a wanted key that is no array.
pub(crate) fn parse(bytes: &[u8], path: &Path, wanted: &[&str]) -> Result<Arrays> {
    let pickle = machine::run(bytes).map_err(|e| Error::format(path, "pickle", e))?;
    let root = pickle.root;
    if !matches!(pickle.node(root), Some(Node::Dict(_))) {
        let problem = format!("holds {}, not a dictionary", pickle.name(root));
        return Err(Error::format(path, "pickle", problem));
    }
    let mut arrays = Arrays::of_file(path);
    for &key in wanted {
        if let Some(value) = pickle.get(root, key) {
            let item = pickle.item(value, arrays.room());
            arrays.insert(key, item.map_err(|e| Error::format(path, key, e))?);
        }
    }
    Ok(arrays)
}

/// Reads a pickle that holds one array, as `.npy` files do whose elements are objects.
pub(crate) fn parse_array(bytes: &[u8], room: usize) -> Result<Item, String> {
    let pickle = machine::run(bytes)?;
    pickle.item(pickle.root, room)
}
