//! The stack machine: opcodes to nodes.

use super::input::{Input, decimal, memo_index};
use super::stack::Machine;
use super::text::{from_latin1, from_literal, from_raw_unicode};
use super::{MOST_OPCODES, Node, Pickle, Value};
use std::borrow::Cow;
use std::collections::HashMap;

/// Newest protocol.
const PROTOCOL: u8 = 5;

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

impl Machine<'_> {
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
}
