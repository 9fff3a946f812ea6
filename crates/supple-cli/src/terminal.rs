//! What goes to the terminal: lines, tables, JSON, bars.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::Write;
use std::process::ExitCode;
use supple::{Error, Result};
use supple_bake::PHASES;

/// What a command ends with; an error goes to stderr.
pub fn exit(result: Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Writes a line to stdout; a closed pipe ends the output, not the command.
pub fn print(text: impl std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{text}");
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

/// A bar over the phases of the bake of a body with the given name.
pub fn baking(name: &str) -> impl FnMut(usize) {
    let bar = bar(PHASES.len(), name);
    move |phase| show_phase(&bar, phase)
}

/// The same for a bake that may turn out not to be needed, whose body's name comes with its phases.
pub fn baking_if_needed() -> impl FnMut(&str, usize) {
    let mut shown = None;
    move |name, phase| show_phase(shown.get_or_insert_with(|| bar(PHASES.len(), name)), phase)
}

fn show_phase(bar: &ProgressBar, phase: usize) {
    bar.set_position(phase as u64);
    match PHASES.get(phase) {
        Some(name) => bar.set_message(*name),
        None => bar.finish_and_clear(),
    }
}
