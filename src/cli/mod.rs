//! The `supple` command: arguments in, files and tables out. What it does is in the library.

mod adapters;
mod bake;
mod bake_report;
mod figures;
mod inspect;
mod motion;
mod preview;
mod progress;
mod sample;
mod simulate;

use crate::{Error, Result};
use clap::{Parser, Subcommand};
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

/// Real-time soft tissue for skinned avatars.
#[derive(Parser)]
#[command(name = "supple", version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Bake a character file (or a recipe's) into one file that simulates.
    Bake(bake::Arguments),
    /// Simulate a scene: pictures, a GLB file and a report.
    Simulate(simulate::Arguments),
    /// Run the figures of the paper, and write a page with their pictures, measures and checks.
    Figures(figures::Arguments),
    /// Say what is in a baked file, or in a character file before it is baked.
    Inspect(inspect::Arguments),
    /// Say what is in a motion, and draw an avatar that follows it.
    Motion(motion::Arguments),
    /// List the graphics adapters of this machine.
    Adapters(adapters::Arguments),
    /// Write a sample model and its recipe.
    Sample(sample::Arguments),
}

/// Runs the command; an error goes to stderr, and the exit code is 1.
pub fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Bake(arguments) => arguments.run(),
        Command::Simulate(arguments) => arguments.run(),
        Command::Figures(arguments) => arguments.run(),
        Command::Inspect(arguments) => arguments.run(),
        Command::Motion(arguments) => arguments.run(),
        Command::Adapters(arguments) => arguments.run(),
        Command::Sample(arguments) => arguments.run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Writes a line to stdout; a closed pipe ends the output, not the command.
fn print(text: impl std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// Writes a value to stdout as JSON.
fn print_json(value: &impl serde::Serialize) -> Result<()> {
    print(to_json(value)?);
    Ok(())
}

fn to_json(value: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(value)
        .map_err(|e| Error::invalid("report", format!("cannot be written as JSON: {e}")))
}

fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| Error::io(path, e))
}

/// Two columns: names and values.
fn print_table<'a>(rows: impl IntoIterator<Item = (&'a str, String)>) {
    for (name, value) in rows {
        print(format_args!("{name:<28} {value}"));
    }
}
