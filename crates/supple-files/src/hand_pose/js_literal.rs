//! Object literals of JavaScript, as data files write them: names without quotes, single quotes, comments,
//! trailing commas. Nothing is executed; JSON is among what is read.

use serde_json::{Map, Value};

/// Deepest nesting.
const DEEPEST: usize = 64;

/// The first object literal in `text`: what stands before its brace (`export const pose =`) is passed over.
/// The error names its line.
pub(super) fn first_object(text: &str) -> Result<Value, (usize, String)> {
    let mut parser = Parser { text, at: 0 };
    parser.skip_to_object();
    let value = parser.value(0);
    value.map_err(|problem| (1 + text[..parser.at].matches('\n').count(), problem))
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl Parser<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn bump(&mut self) {
        self.at += self.peek().map_or(0, char::len_utf8);
    }

    /// To the first brace outside of comments.
    fn skip_to_object(&mut self) {
        loop {
            self.skip_blank();
            match self.peek() {
                None | Some('{') => return,
                _ => self.bump(),
            }
        }
    }

    /// Past white space and comments.
    fn skip_blank(&mut self) {
        loop {
            let rest = self.rest();
            let length = if rest.starts_with("//") {
                rest.find('\n').unwrap_or(rest.len())
            } else if rest.starts_with("/*") {
                rest.find("*/").map_or(rest.len(), |end| end + 2)
            } else {
                rest.len() - rest.trim_start().len()
            };
            if length == 0 {
                return;
            }
            self.at += length;
        }
    }

    /// Whether `c` comes next; it is passed.
    fn take(&mut self, c: char) -> bool {
        self.skip_blank();
        let there = self.peek() == Some(c);
        if there {
            self.bump();
        }
        there
    }

    fn value(&mut self, depth: usize) -> Result<Value, String> {
        if depth > DEEPEST {
            return Err(format!("is nested deeper than {DEEPEST}"));
        }
        if self.take('{') {
            return self.object(depth);
        }
        if self.take('[') {
            let mut items = Vec::new();
            while !self.take(']') {
                items.push(self.value(depth + 1)?);
                self.separate(']')?;
            }
            return Ok(Value::Array(items));
        }
        self.skip_blank();
        if matches!(self.peek(), Some('\'' | '"')) {
            return Ok(Value::String(self.name()?));
        }
        let end = self
            .rest()
            .find(|c: char| !c.is_ascii_alphanumeric() && !"+-._$".contains(c));
        let word = self.rest()[..end.unwrap_or(self.rest().len())].to_string();
        let value = match word.as_str() {
            "true" => Value::Bool(true),
            "false" => Value::Bool(false),
            "null" | "undefined" => Value::Null,
            _ => word
                .parse::<f64>()
                .ok()
                .and_then(serde_json::Number::from_f64)
                .map(Value::Number)
                .ok_or_else(|| format!("a value is expected, not {:?}", word.chars().next()))?,
        };
        self.at += word.len();
        Ok(value)
    }

    fn object(&mut self, depth: usize) -> Result<Value, String> {
        let mut object = Map::new();
        while !self.take('}') {
            let name = self.name()?;
            if !self.take(':') {
                return Err(format!("`:` is expected after {name:?}"));
            }
            let value = self.value(depth + 1)?;
            object.insert(name, value);
            self.separate('}')?;
        }
        Ok(Value::Object(object))
    }

    /// A comma, or what closes.
    fn separate(&mut self, close: char) -> Result<(), String> {
        self.skip_blank();
        match self.take(',') || self.peek() == Some(close) {
            true => Ok(()),
            false => Err(format!("`,` or `{close}` is expected")),
        }
    }

    /// A quoted text without escapes, or a plain name.
    fn name(&mut self) -> Result<String, String> {
        self.skip_blank();
        let Some(quote) = self.peek().filter(|c| matches!(c, '\'' | '"')) else {
            let rest = self.rest();
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_' && c != '$');
            let name = rest[..end.unwrap_or(rest.len())].to_string();
            if name.is_empty() {
                return Err("a name is expected".into());
            }
            self.at += name.len();
            return Ok(name);
        };
        let rest = &self.rest()[1..];
        let end = rest.find([quote, '\\', '\n']).unwrap_or(rest.len());
        if !rest[end..].starts_with(quote) {
            return Err("a text does not end, or holds a backslash".into());
        }
        let name = rest[..end].to_string();
        self.at += end + 2;
        Ok(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_data_files_write_is_read() {
        let text = "/* { */ export const pose = { // one\n a: [1, -2.5e-3, ],\n 'b-c': {\"d\": true,}, e: 'x', };";
        let expected = json!({"a": [1.0, -0.0025], "b-c": {"d": true}, "e": "x"});
        assert_eq!(first_object(text).unwrap(), expected);
        assert_eq!(first_object("{}").unwrap(), json!({}));
    }

    #[test]
    fn what_is_broken_is_named_by_its_line() {
        for (text, line, hint) in [
            ("", 1, "a value"),
            ("\n{a: }", 2, "a value"),
            ("{a 1}", 1, "`:`"),
            ("{a: 1 b: 2}", 1, "`,`"),
            ("{\n'a", 2, "does not end"),
            ("{a: f()}", 1, "a value"),
            ("{a: 1e999}", 1, "a value"),
            ("{é: ü}", 1, "a value"),
        ] {
            let (at, problem) = first_object(text).unwrap_err();
            assert!(
                at == line && problem.contains(hint),
                "{text}: {at} {problem}"
            );
        }
        let deep = "{a:".to_string() + &"[".repeat(100_000);
        assert!(first_object(&deep).unwrap_err().1.contains("deeper"));
    }
}
