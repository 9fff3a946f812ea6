//! The stack machine: opcodes to nodes.

use super::globals::{self, Global};
use super::text::{from_latin1, from_literal, from_raw_unicode};
use super::{MOST_OPCODES, Node, Pickle, Value};
use std::borrow::Cow;
use std::collections::HashMap;

/// Newest protocol.
const PROTOCOL: u8 = 5;

/// Longest name of a class with its module, bytes.
const LONGEST_NAME: usize = 200;

/// Opcodes that pickles of arrays have no use for.
const REFUSED: &[(u8, &str)] = &[
    (b'P', "PERSID"),
    (b'Q', "BINPERSID"),
    (b'i', "INST"),
    (b'o', "OBJ"),
    (0x82, "EXT1"),
    (0x83, "EXT2"),
    (0x84, "EXT4"),
    (0x97, "NEXT_BUFFER"),
    (0x98, "READONLY_BUFFER"),
];

/// Runs the pickle in `bytes`; the error says at which byte it failed.
pub(super) fn run(bytes: &[u8]) -> Result<Pickle<'_>, String> {
    let mut machine = Machine {
        input: Input { bytes, at: 0 },
        nodes: Vec::new(),
        stack: Vec::new(),
        marks: Vec::new(),
        memo: HashMap::new(),
        left: MOST_OPCODES,
    };
    loop {
        let at = machine.input.at;
        match machine.step() {
            Ok(None) => {}
            Ok(Some(root)) => {
                return Ok(Pickle {
                    nodes: machine.nodes,
                    root,
                });
            }
            Err(problem) => return Err(format!("byte {at}: {problem}")),
        }
    }
}

struct Machine<'a> {
    input: Input<'a>,
    nodes: Vec<Node<'a>>,
    stack: Vec<Value>,
    /// Heights of the stack at which marks lie.
    marks: Vec<usize>,
    memo: HashMap<u32, Value>,
    /// Opcodes that may still be run.
    left: usize,
}

impl<'a> Machine<'a> {
    /// Runs one opcode; the pickle's value at its end.
    fn step(&mut self) -> Result<Option<Value>, String> {
        self.spend(1)?;
        let opcode = self.input.byte()?;
        match opcode {
            // Framing.
            0x80 => {
                let protocol = self.input.byte()?;
                if protocol > PROTOCOL {
                    return Err(format!(
                        "protocol {protocol} is not read; save with protocol 2 or 4"
                    ));
                }
            }
            0x95 => {
                self.input.take(8)?; // a frame's length: frames are read through
            }
            b'.' => return self.pop().map(Some),
            // Plain values.
            b'N' => self.stack.push(Value::None),
            0x88 => self.stack.push(Value::Bool(true)),
            0x89 => self.stack.push(Value::Bool(false)),
            b'I' => {
                let value = match self.input.line()? {
                    b"00" => Value::Bool(false),
                    b"01" => Value::Bool(true),
                    line => decimal(line)?,
                };
                self.stack.push(value);
            }
            b'L' => {
                let line = self.input.line()?;
                let value = decimal(line.strip_suffix(b"L").unwrap_or(line))?;
                self.stack.push(value);
            }
            b'J' => {
                let int = self.input.count(4)? as u32 as i32;
                self.stack.push(Value::Int(int.into()));
            }
            b'K' => self.push_count(1)?,
            b'M' => self.push_count(2)?,
            0x8a => self.push_long(1)?,
            0x8b => self.push_long(4)?,
            b'F' => {
                let line = from_latin1(self.input.line()?);
                let float = line.trim().parse().map_err(|_| "a number is expected")?;
                self.stack.push(Value::Float(float));
            }
            b'G' => {
                let bytes = self.input.take(8)?.try_into().unwrap_or_default();
                self.stack.push(Value::Float(f64::from_be_bytes(bytes)));
            }
            // Texts and bytes.
            b'S' => {
                let bytes = from_literal(self.input.line()?.trim_ascii())?;
                self.push(Node::Bytes(Cow::Owned(bytes)));
            }
            b'V' => {
                let text = from_raw_unicode(self.input.line()?)?;
                self.push(Node::Text(Cow::Owned(text)));
            }
            b'U' | b'C' => self.push_bytes(1)?,
            b'T' | b'B' => self.push_bytes(4)?,
            0x8e | 0x96 => self.push_bytes(8)?,
            0x8c => self.push_text(1)?,
            b'X' => self.push_text(4)?,
            0x8d => self.push_text(8)?,
            // Containers.
            b'(' => self.marks.push(self.stack.len()),
            b']' | b')' | 0x8f => self.push(Node::Sequence(Vec::new())),
            b'l' | b't' | 0x91 => {
                let items = self.pop_to_mark()?;
                self.push(Node::Sequence(items));
            }
            0x85 => self.push_tuple::<1>()?,
            0x86 => self.push_tuple::<2>()?,
            0x87 => self.push_tuple::<3>()?,
            b'a' => {
                let item = self.pop()?;
                self.append([item])?;
            }
            b'e' | 0x90 => {
                let items = self.pop_to_mark()?;
                self.append(items)?;
            }
            b'}' => self.push(Node::Dict(Vec::new())),
            b'd' => {
                let items = self.pop_to_mark()?;
                self.push(Node::Dict(Vec::new()));
                self.set_items(&items)?;
            }
            b's' => {
                let value = self.pop()?;
                let key = self.pop()?;
                self.set_items(&[key, value])?;
            }
            b'u' => {
                let items = self.pop_to_mark()?;
                self.set_items(&items)?;
            }
            // The stack and the memo.
            b'0' => {
                self.pop()?;
            }
            b'1' => {
                self.pop_to_mark()?;
            }
            b'2' => self.stack.push(self.top()?),
            b'p' => {
                let index = memo_index(self.input.line()?)?;
                self.memo.insert(index, self.top()?);
            }
            b'q' => {
                let index = self.input.count(1)? as u32;
                self.memo.insert(index, self.top()?);
            }
            b'r' => {
                let index = self.input.count(4)? as u32;
                self.memo.insert(index, self.top()?);
            }
            0x94 => {
                let index = self.memo.len() as u32;
                self.memo.insert(index, self.top()?);
            }
            b'g' => {
                let index = memo_index(self.input.line()?)?;
                self.recall(index)?;
            }
            b'h' => {
                let index = self.input.count(1)? as u32;
                self.recall(index)?;
            }
            b'j' => {
                let index = self.input.count(4)? as u32;
                self.recall(index)?;
            }
            // Objects.
            b'c' => {
                let module = from_latin1(self.input.line()?);
                let name = from_latin1(self.input.line()?);
                self.push_class(&module, &name)?;
            }
            0x93 => {
                let name = self.pop_name()?;
                let module = self.pop_name()?;
                self.push_class(&module, &name)?;
            }
            b'R' | 0x81 => {
                let arguments = self.pop()?;
                self.call(arguments)?;
            }
            0x92 => {
                self.pop()?; // named arguments: no class on the list has any
                let arguments = self.pop()?;
                self.call(arguments)?;
            }
            b'b' => {
                let new_state = self.pop()?;
                match self.top_node()? {
                    Node::Call { state, .. } => *state = new_state,
                    _ => return Err("a state is set on what has none".into()),
                }
            }
            _ => {
                let refused = REFUSED.iter().find(|r| r.0 == opcode);
                let name = refused.map_or("unknown", |r| r.1);
                return Err(format!("opcode {opcode:#04x} ({name}) is not read"));
            }
        }
        Ok(None)
    }

    fn spend(&mut self, opcodes: usize) -> Result<(), String> {
        self.left = (self.left.checked_sub(opcodes))
            .ok_or_else(|| format!("more than {MOST_OPCODES} opcodes: this is no body model"))?;
        Ok(())
    }

    fn push(&mut self, node: Node<'a>) {
        self.stack.push(Value::Node(self.nodes.len() as u32));
        self.nodes.push(node);
    }

    /// Height below which this mark's opcodes may not reach.
    fn floor(&self) -> usize {
        self.marks.last().copied().unwrap_or(0)
    }

    fn top(&self) -> Result<Value, String> {
        let above = self.stack.get(self.floor()..).unwrap_or_default();
        above.last().copied().ok_or_else(|| EMPTY.to_string())
    }

    fn pop(&mut self) -> Result<Value, String> {
        let top = self.top()?;
        self.stack.pop();
        Ok(top)
    }

    fn pop_to_mark(&mut self) -> Result<Vec<Value>, String> {
        let mark = self.marks.pop().ok_or("a mark is missing")?;
        Ok(self.stack.split_off(mark.min(self.stack.len())))
    }

    /// The node on top of the stack.
    fn top_node(&mut self) -> Result<&mut Node<'a>, String> {
        let Value::Node(index) = self.top()? else {
            return Err("a plain value stands where an object is needed".into());
        };
        self.nodes
            .get_mut(index as usize)
            .ok_or_else(|| EMPTY.into())
    }

    fn push_count(&mut self, width: usize) -> Result<(), String> {
        let int = self.input.count(width)? as i64;
        self.stack.push(Value::Int(int));
        Ok(())
    }

    /// An integer in two's complement, lowest byte first, its length before it.
    fn push_long(&mut self, width: usize) -> Result<(), String> {
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

    fn push_bytes(&mut self, width: usize) -> Result<(), String> {
        let bytes = self.input.counted(width)?;
        self.push(Node::Bytes(Cow::Borrowed(bytes)));
        Ok(())
    }

    fn push_text(&mut self, width: usize) -> Result<(), String> {
        let bytes = self.input.counted(width)?;
        let text = std::str::from_utf8(bytes).map_err(|_| "a text is not UTF-8")?;
        self.push(Node::Text(Cow::Borrowed(text)));
        Ok(())
    }

    fn push_tuple<const N: usize>(&mut self) -> Result<(), String> {
        let mut items = [Value::None; N];
        for item in items.iter_mut().rev() {
            *item = self.pop()?;
        }
        self.push(Node::Sequence(items.to_vec()));
        Ok(())
    }

    fn append(&mut self, items: impl IntoIterator<Item = Value>) -> Result<(), String> {
        match self.top_node()? {
            Node::Sequence(list) => list.extend(items),
            _ => return Err("items are appended to what is no list".into()),
        }
        Ok(())
    }

    /// Keys and values in turn, into the dictionary on top of the stack.
    fn set_items(&mut self, items: &[Value]) -> Result<(), String> {
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

    fn recall(&mut self, index: u32) -> Result<(), String> {
        let value = self.memo.get(&index).copied();
        self.stack
            .push(value.ok_or_else(|| format!("nothing was remembered as {index}"))?);
        Ok(())
    }

    fn pop_name(&mut self) -> Result<String, String> {
        let value = self.pop()?;
        let node = match value {
            Value::Node(index) => self.nodes.get(index as usize),
            _ => None,
        };
        match node {
            Some(Node::Text(name)) if name.len() <= LONGEST_NAME => Ok(name.to_string()),
            _ => Err("a class's name must be a short text".into()),
        }
    }

    fn push_class(&mut self, module: &str, name: &str) -> Result<(), String> {
        let full: String = format!("{module}.{name}")
            .chars()
            .take(LONGEST_NAME)
            .collect();
        let global = globals::find(module, name).ok_or_else(|| {
            format!(
                "names {full}, which is not on the list of what a body model may hold: \
                 save the model as plain arrays"
            )
        })?;
        self.push(Node::Class(global, full));
        Ok(())
    }

    /// Calls the class on top of the stack: nothing runs, the call is written down.
    fn call(&mut self, arguments: Value) -> Result<(), String> {
        let callee = self.pop()?;
        let (class, arguments) = match self.class(callee)? {
            Global::Reconstructor | Global::NewObject => {
                let first = self.items(arguments)?.first().copied();
                (first.ok_or("an object of no class")?, Value::None)
            }
            Global::OrderedDict => return self.ordered_dict(arguments),
            _ => (callee, arguments),
        };
        self.class(class)?;
        let Value::Node(class) = class else {
            return Err(EMPTY.into());
        };
        self.push(Node::Call {
            class,
            arguments,
            state: Value::None,
        });
        Ok(())
    }

    /// A dictionary of the pairs that the arguments list, if they do.
    fn ordered_dict(&mut self, arguments: Value) -> Result<(), String> {
        let mut entries = Vec::new();
        if let Some(&pairs) = self.items(arguments)?.first() {
            // This copies what may be shared: it counts as opcodes.
            self.spend(self.items(pairs)?.len())?;
            for &pair in self.items(pairs)? {
                match *self.items(pair)? {
                    [key, value] => entries.push((key, value)),
                    _ => return Err("a dictionary's pair is none".into()),
                }
            }
        }
        self.push(Node::Dict(entries));
        Ok(())
    }

    fn class(&self, value: Value) -> Result<Global, String> {
        let node = match value {
            Value::Node(index) => self.nodes.get(index as usize),
            _ => None,
        };
        match node {
            Some(Node::Class(global, _)) => Ok(*global),
            _ => Err("what is called is no class".into()),
        }
    }

    fn items(&self, value: Value) -> Result<&[Value], String> {
        let node = match value {
            Value::Node(index) => self.nodes.get(index as usize),
            _ => None,
        };
        match node {
            Some(Node::Sequence(items)) => Ok(items),
            _ => Err("a list of arguments is none".into()),
        }
    }
}

const EMPTY: &str = "the stack is empty";

/// The bytes that are left.
struct Input<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Input<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        let taken = taken.ok_or_else(|| {
            format!(
                "{count} bytes are announced and {} are left",
                self.bytes.len() - self.at
            )
        })?;
        self.at += count;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.take(1).map(|b| b[0])
    }

    /// An unsigned integer of so many bytes, lowest first.
    fn count(&mut self, width: usize) -> Result<u64, String> {
        let bytes = self.take(width)?;
        Ok(bytes.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)))
    }

    /// Bytes with their number, of so many bytes, before them.
    fn counted(&mut self, width: usize) -> Result<&'a [u8], String> {
        let count = self.count(width)?;
        self.take(usize::try_from(count).unwrap_or(usize::MAX))
    }

    /// Up to the end of the line.
    fn line(&mut self) -> Result<&'a [u8], String> {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|b| *b == b'\n');
        let length = length.ok_or("a line has no end")?;
        self.at += length + 1;
        Ok(rest[..length]
            .strip_suffix(b"\r")
            .unwrap_or(&rest[..length]))
    }
}

fn decimal(line: &[u8]) -> Result<Value, String> {
    let text = from_latin1(line);
    let int = text.trim().parse().map(Value::Int);
    int.map_err(|_| "an integer of 64 bits is expected".into())
}

fn memo_index(line: &[u8]) -> Result<u32, String> {
    let text = from_latin1(line);
    let index = text.trim().parse();
    index.map_err(|_| "an index of the memo is expected".into())
}
