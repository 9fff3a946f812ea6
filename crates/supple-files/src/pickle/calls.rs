//! Classes and calls: written down, never run.

use super::globals::{self, Global};
use super::stack::{EMPTY, LONGEST_NAME, Machine};
use super::{Node, Value};

impl Machine<'_> {
    pub fn push_class(&mut self, module: &str, name: &str) -> Result<(), String> {
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
    pub fn call(&mut self, arguments: Value) -> Result<(), String> {
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
        match self.node(value) {
            Some(Node::Class(global, _)) => Ok(*global),
            _ => Err("what is called is no class".into()),
        }
    }

    fn items(&self, value: Value) -> Result<&[Value], String> {
        match self.node(value) {
            Some(Node::Sequence(items)) => Ok(items),
            _ => Err("a list of arguments is none".into()),
        }
    }
}
