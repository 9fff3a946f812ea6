//! The `supple` command: arguments in, files and tables out. What it does is in the library.

mod adapters;
mod animations;
mod backend;
mod bake;
mod bake_report;
mod body_flags;
mod figures;
mod glb_flags;
mod inspect;
mod motion;
mod motion_flags;
mod play;
mod preview;
mod sample;
mod simulate;
mod simulate_report;
pub mod terminal;
#[cfg(feature = "view")]
mod view;

use clap::{Parser, Subcommand};
use std::path::Path;
use std::process::ExitCode;
use supple::{Error, Result};

/// Real-time soft tissue for skinned avatars.
#[derive(Parser)]
#[command(name = "supple", version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Show a character: bake it, play its clip or shake it, and write a moving picture and a GLB file.
    Play(play::Arguments),
    /// Open a window: drop a character in, pull at it, press it, throw things at it.
    #[cfg(feature = "view")]
    View(view::Arguments),
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
    let arguments: Arguments = match terminal::parse() {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    terminal::exit(match arguments.command {
        Command::Play(arguments) => arguments.run(),
        #[cfg(feature = "view")]
        Command::View(arguments) => arguments.run(),
        Command::Bake(arguments) => arguments.run(),
        Command::Simulate(arguments) => arguments.run(),
        Command::Figures(arguments) => arguments.run(),
        Command::Inspect(arguments) => arguments.run(),
        Command::Motion(arguments) => arguments.run(),
        Command::Adapters(arguments) => arguments.run(),
        Command::Sample(arguments) => arguments.run(),
    })
}

fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| Error::io(path, e))
}
