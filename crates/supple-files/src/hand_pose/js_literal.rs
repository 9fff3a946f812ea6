//! Object literals of JavaScript, as data files write them. Nothing is executed: JSON5 is what is read.

use json5::Deserializer;
use serde::Deserialize;
use serde_json::Value;

/// Deepest nesting: the parser calls itself for each bracket.
const DEEPEST: usize = 64;

/// What ends a line, and a comment with it, in JavaScript.
const LINE_ENDS: [char; 4] = ['\n', '\r', '\u{2028}', '\u{2029}'];

/// The first object literal in `text`: what stands before its brace (`export const pose =`) is passed over, and what
/// comes after it left alone. The error names its line.
pub(super) fn first_object(text: &str) -> Result<Value, (usize, String)> {
    let line = |at: usize| 1 + text[..at].matches('\n').count();
    let start = first_brace(text).map_err(|(at, problem)| (line(at), problem))?;
    Value::deserialize(&mut Deserializer::from_str(&text[start..])).map_err(|error| {
        // Where the text ends too early, that of what is left open.
        let below = error.position().map_or(0, |p| p.line);
        let problem = error.code().map(|code| code.to_string());
        let problem = problem.unwrap_or("a number that cannot be read".into());
        (line(start) + below, problem)
    })
}

/// Where the first object begins; or where its brackets are nested too deep.
fn first_brace(text: &str) -> Result<usize, (usize, String)> {
    let (mut at, mut start, mut depth) = (0, None, 0);
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        match c {
            '{' | '[' if start.is_some() || c == '{' => {
                start = start.or(Some(at));
                depth += 1;
            }
            '}' | ']' if start.is_some() => depth -= 1,
            _ => {}
        }
        match start {
            Some(start) if depth == 0 => return Ok(start),
            _ if depth > DEEPEST => return Err((at, format!("is nested deeper than {DEEPEST}"))),
            _ => {}
        }
        at += match c {
            '/' if rest.starts_with("//") => rest.find(LINE_ENDS).unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => {
                (rest[2..].find("*/")).map_or(rest.len(), |length| length + 4)
            }
            '"' | '\'' if start.is_some() => quoted(rest),
            _ => c.len_utf8(),
        };
    }
    start.ok_or((text.len(), "`{` is expected: there is no object".into()))
}

/// Length of the quoted text that `rest` begins with.
fn quoted(rest: &str) -> usize {
    let quote = rest.chars().next();
    let mut escaped = false;
    for (at, c) in rest.char_indices().skip(1) {
        if !escaped && Some(c) == quote {
            return at + 1;
        }
        escaped = !escaped && c == '\\';
    }
    rest.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_data_files_write_is_read() {
        let text = "/* { */ export const pose = { // one\n a: [1, -2.5e-3, ],\n 'b-c': {\"d\": true,}, e: 'it\\'s }', };\n}";
        let expected = json!({"a": [1, -0.0025], "b-c": {"d": true}, "e": "it's }"});
        assert_eq!(first_object(text).unwrap(), expected);
        assert_eq!(first_object("{}").unwrap(), json!({}));
    }

    #[test]
    fn what_is_broken_is_named_by_its_line() {
        for (text, line, hint) in [
            ("", 1, "`{`"),
            ("\n{a: }", 2, "expected value"),
            ("{a 1}", 1, "expected colon"),
            ("\n{\na: 1 b: 2}", 3, "expected comma"),
            ("\n{'a", 2, "EOF parsing string"),
            ("{a: f()}", 1, "expected"),
            ("{a:\n1e5e5}", 2, "number"),
            ("{a:\n[1, 2", 2, "EOF parsing array"),
        ] {
            let (at, problem) = first_object(text).unwrap_err();
            assert!(
                at == line && problem.contains(hint),
                "{text}: {at} {problem}"
            );
        }
    }

    #[test]
    fn no_depth_overflows_the_stack() {
        let deep = "[".repeat(100_000);
        // Brackets that close in a text or a comment close nothing.
        for text in [
            format!("{{a:{deep}"),
            format!("{{a:{}", "[']', ".repeat(100_000)),
            format!("{{a:{}", "[']\\']', ".repeat(100_000)),
            format!("{{a:{}", "[/*]*/".repeat(100_000)),
            format!("{{a:{}", "[//]\r".repeat(100_000)),
            format!("{{a:{}", "[/*/]*/".repeat(100_000)),
        ] {
            assert!(first_object(&text).unwrap_err().1.contains("deeper"));
        }
    }
}
