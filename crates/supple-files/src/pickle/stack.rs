//! The machine's memory: nodes, stack, marks and memo.

use super::input::Input;
use super::{MOST_OPCODES, Node, Value};
use std::borrow::Cow;
use std::collections::HashMap;

/// Longest name of a class or module, bytes.
pub(super) const LONGEST_NAME: usize = 200;

/// See [`super::machine`].
pub(super) struct Machine<'a> {
    pub input: Input<'a>,
    pub nodes: Vec<Node<'a>>,
    pub stack: Vec<Value>,
    /// Heights of the stack at which marks lie.
    pub marks: Vec<usize>,
    pub memo: HashMap<u32, Value>,
    /// Opcodes that may still be run.
    pub left: usize,
}

impl<'a> Machine<'a> {
    pub fn spend(&mut self, opcodes: usize) -> Result<(), String> {
        self.left = (self.left.checked_sub(opcodes))
            .ok_or_else(|| format!("more than {MOST_OPCODES} opcodes: this is no body model"))?;
        Ok(())
    }

    pub fn push(&mut self, node: Node<'a>) {
        self.stack.push(Value::Node(self.nodes.len() as u32));
        self.nodes.push(node);
    }

    /// Height below which this mark's opcodes may not reach.
    pub fn floor(&self) -> usize {
        self.marks.last().copied().unwrap_or(0)
    }

    pub fn top(&self) -> Result<Value, String> {
        let above = self.stack.get(self.floor()..).unwrap_or_default();
        above.last().copied().ok_or_else(|| EMPTY.to_string())
    }

    pub fn pop(&mut self) -> Result<Value, String> {
        let top = self.top()?;
        self.stack.pop();
        Ok(top)
    }

    pub fn pop_to_mark(&mut self) -> Result<Vec<Value>, String> {
        let mark = self.marks.pop().ok_or("a mark is missing")?;
        Ok(self.stack.split_off(mark.min(self.stack.len())))
    }

    /// The node that a value is.
    pub fn node(&self, value: Value) -> Option<&Node<'a>> {
        match value {
            Value::Node(index) => self.nodes.get(index as usize),
            _ => None,
        }
    }

    /// The node on top of the stack.
    pub fn top_node(&mut self) -> Result<&mut Node<'a>, String> {
        let Value::Node(index) = self.top()? else {
            return Err("a plain value stands where an object is needed".into());
        };
        self.nodes
            .get_mut(index as usize)
            .ok_or_else(|| EMPTY.into())
    }

    pub fn push_count(&mut self, width: usize) -> Result<(), String> {
        let int = self.input.count(width)? as i64;
        self.stack.push(Value::Int(int));
        Ok(())
    }

    /// An integer in two's complement, lowest byte first, its length before it.
    pub fn push_long(&mut self, width: usize) -> Result<(), String> {
        let length = self.input.count(width)? as usize;
        let bytes = self.input.take(length)?;
        if length > 8 {
            return Err(format!("an integer of {length} bytes is not read"));
        }
        let negative = bytes.last().is_some_and(|b| b & 0x80 != 0);
        let mut padded = [if negative { 0xff } else { 0 }; 8];
        padded[..length].copy_from_slice(bytes);
        self.stack.push(Value::Int(i64::from_le_bytes(padded)));
        Ok(())
    }

    pub fn push_bytes(&mut self, width: usize) -> Result<(), String> {
        let bytes = self.input.counted(width)?;
        self.push(Node::Bytes(Cow::Borrowed(bytes)));
        Ok(())
    }

    pub fn push_text(&mut self, width: usize) -> Result<(), String> {
        let bytes = self.input.counted(width)?;
        let text = std::str::from_utf8(bytes).map_err(|_| "a text is not UTF-8")?;
        self.push(Node::Text(Cow::Borrowed(text)));
        Ok(())
    }

    pub fn push_tuple<const N: usize>(&mut self) -> Result<(), String> {
        let mut items = [Value::None; N];
        for item in items.iter_mut().rev() {
            *item = self.pop()?;
        }
        self.push(Node::Sequence(items.to_vec()));
        Ok(())
    }

    pub fn append(&mut self, items: impl IntoIterator<Item = Value>) -> Result<(), String> {
        match self.top_node()? {
            Node::Sequence(list) => list.extend(items),
            _ => return Err("items are appended to what is no list".into()),
        }
        Ok(())
    }

    /// Keys and values in turn, into the dictionary on top of the stack.
    pub fn set_items(&mut self, items: &[Value]) -> Result<(), String> {
        let (pairs, rest) = items.as_chunks::<2>();
        if !rest.is_empty() {
            return Err("a key without its value".into());
        }
        match self.top_node()? {
            Node::Dict(entries) => entries.extend(pairs.iter().map(|&[key, value]| (key, value))),
            _ => return Err("keys are set in what is no dictionary".into()),
        }
        Ok(())
    }

    pub fn recall(&mut self, index: u32) -> Result<(), String> {
        let value = self.memo.get(&index).copied();
        self.stack
            .push(value.ok_or_else(|| format!("nothing was remembered as {index}"))?);
        Ok(())
    }

    pub fn pop_name(&mut self) -> Result<String, String> {
        let value = self.pop()?;
        match self.node(value) {
            Some(Node::Text(name)) if name.len() <= LONGEST_NAME => Ok(name.to_string()),
            _ => Err("a class's name must be a short text".into()),
        }
    }
}

/// What an opcode says that finds nothing.
pub(super) const EMPTY: &str = "the stack is empty";
