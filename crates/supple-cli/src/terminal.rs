//! What goes to the terminal: lines, tables, JSON, bars.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::Instant;
use supple::{Error, Result};
use supple_bake::PHASES;

/// What first went wrong on standard output, until the command ends with it.
static BROKEN: Mutex<Option<io::Error>> = Mutex::new(None);

/// The command's arguments, or the exit code of help and wrong usage, which are printed.
pub fn parse<A: clap::Parser>() -> Result<A, ExitCode> {
    A::try_parse().map_err(|message| {
        let printed = message.print().and_then(|()| io::stdout().flush());
        match (printed, message.use_stderr()) {
            (Err(e), false) => exit(Err(stdout_error(e))),
            _ => ExitCode::from(u8::try_from(message.exit_code()).unwrap_or(1)),
        }
    })
}

/// What a command ends with; an error, also of standard output, goes to stderr.
pub fn exit(result: Result<()>) -> ExitCode {
    remember(io::stdout().flush());
    let broken = BROKEN.lock().ok().and_then(|mut broken| broken.take());
    match (result, broken) {
        (Ok(()), None) => ExitCode::SUCCESS,
        (Ok(()), Some(e)) => exit(Err(stdout_error(e))),
        (Err(error), _) => {
            tell(format_args!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Writes a line to stdout. Where that fails (a closed pipe, a full disk) the command goes on without it, since it may have
/// files to write; [`exit`] then ends it with the error.
pub fn print(text: impl std::fmt::Display) {
    if BROKEN.lock().is_ok_and(|broken| broken.is_none()) {
        remember(writeln!(io::stdout(), "{text}"));
    }
}

/// Writes a line to stderr, if anybody hears it.
pub fn tell(text: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "{text}");
}

fn remember(written: io::Result<()>) {
    if let (Err(e), Ok(mut broken)) = (written, BROKEN.lock()) {
        broken.get_or_insert(e);
    }
}

fn stdout_error(source: io::Error) -> Error {
    Error::io("standard output", source)
}

/// Writes a value to stdout as JSON.
pub fn print_json(value: &impl serde::Serialize) -> Result<()> {
    print(to_json(value)?);
    Ok(())
}

/// A value as JSON.
pub fn to_json(value: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(value)
        .map_err(|e| Error::invalid("report", format!("cannot be written as JSON: {e}")))
}

/// Two columns: names and values.
pub fn print_table<'a>(rows: impl IntoIterator<Item = (&'a str, String)>) {
    for (name, value) in rows {
        print(format_args!("{name:<28} {value}"));
    }
}

/// A bar of `length` steps.
pub fn bar(length: usize, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(length as u64).with_message(what.to_string());
    let style = ProgressStyle::with_template("{msg:>14} {wide_bar} {pos}/{len} {eta}");
    // The template is fixed; were it wrong, the default style would do.
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

/// The phases of the bake of a body with the given name.
pub fn baking(name: &str) -> impl FnMut(usize) {
    let mut shown = Phases::new(name);
    move |phase| shown.show(phase)
}

/// The same for a bake that may turn out not to be needed, whose body's name comes with its phases.
pub fn baking_if_needed() -> impl FnMut(&str, usize) {
    let mut shown = None;
    move |name, phase| shown.get_or_insert_with(|| Phases::new(name)).show(phase)
}

/// A bake's phases on standard error: a bar, or a line a phase where it is no terminal.
struct Phases {
    bar: Option<ProgressBar>,
    name: String,
    since: Instant,
}

impl Phases {
    fn new(name: &str) -> Self {
        let is_terminal = io::stderr().is_terminal();
        Self {
            bar: is_terminal.then(|| bar(PHASES.len(), name)),
            name: name.into(),
            since: Instant::now(),
        }
    }

    fn show(&mut self, phase: usize) {
        let Self { bar, name, since } = self;
        let seconds = since.elapsed().as_secs_f64();
        match (bar, PHASES.get(phase)) {
            (Some(bar), Some(what)) => {
                bar.set_position(phase as u64);
                bar.set_message(*what);
            }
            (Some(bar), None) => bar.finish_and_clear(),
            (None, Some(what)) => eprintln!("{name}: {what}, after {seconds:.1} s"),
            (None, None) => eprintln!("{name}: baked in {seconds:.1} s"),
        }
    }
}
