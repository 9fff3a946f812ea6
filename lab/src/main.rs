//! The command `supple-figures`, which `supple figures` runs: the gallery of figures.

use clap::Parser;
use indicatif::ProgressBar;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;
use supple::{Error, Result};
use supple_cli::terminal::{bar, exit, parse, print, print_json};
use supple_lab::{FIGURES, Figure, Progress, Runner, SeededPresses, Size, Verdict, write_gallery};
use supple_scene::unpack_scenes;

/// Run the figures of the paper, and write a page with their pictures, measures and checks.
#[derive(Parser)]
#[command(name = "supple figures", version)]
struct Arguments {
    /// Where the page, its pictures and figures.json go.
    #[arg(short, long, default_value = "out/figures")]
    output: PathBuf,
    /// Only this figure; may be given several times. The page is then about those.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// The small variants that are tests: seconds each.
    #[arg(long)]
    small: bool,
    /// Names and titles of the figures, and nothing else.
    #[arg(long)]
    list: bool,
    /// Draws the places of `press_anywhere`.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Presses on each body of `press_anywhere`; 5, or 3 of the small variant.
    #[arg(long)]
    count: Option<usize>,
    /// A body of `press_anywhere`: limb_s, limb_m, hand, body, or a character's file; may be given several times.
    #[arg(long, value_name = "NAME|FILE")]
    body: Vec<String>,
    /// Write all measures and checks to stdout as JSON.
    #[arg(long)]
    json: bool,
    /// Where scenes are, in place of those in the program.
    #[arg(long)]
    scenes: Option<PathBuf>,
    /// Where bakes and long runs are kept.
    #[arg(long, default_value = "out/cache")]
    cache: PathBuf,
}

fn main() -> ExitCode {
    parse().map_or_else(|code| code, |arguments: Arguments| exit(arguments.run()))
}

impl Arguments {
    /// Runs the figures and writes the page.
    fn run(self) -> Result<()> {
        if self.list {
            for figure in FIGURES {
                print(format_args!("{:<16} {}", figure.name, figure.title));
            }
            return Ok(());
        }
        let figures = self.chosen()?;
        let size = if self.small { Size::Small } else { Size::Full };
        let bars = Bars::default();
        let show = move |p: Progress<'_>| bars.show(p);
        let scenes = match &self.scenes {
            Some(folder) => folder.clone(),
            None => unpack_scenes(&self.cache)?,
        };
        let mut runner = Runner::new(size, scenes, &self.cache, show);
        runner.presses = SeededPresses {
            seed: self.seed,
            count: self.count,
            bodies: self.body.clone(),
        };
        let mut tell = |verdict: &Verdict| {
            if !self.json {
                print_verdict(verdict);
            }
        };
        let summary = write_gallery(&figures, &runner, &self.output, &mut tell)?;
        let (held, all) = summary.checks();
        if self.json {
            print_json(&summary)?;
        } else {
            print(format_args!("{held} of {all} checks hold"));
            print(format_args!(
                "written to {}",
                self.output.join("index.html").display()
            ));
        }
        match all - held {
            0 => Ok(()),
            failing => Err(Error::invalid(
                "figures",
                format!("{failing} of {all} checks fail"),
            )),
        }
    }

    fn chosen(&self) -> Result<Vec<&'static Figure>> {
        if self.only.is_empty() {
            return Ok(FIGURES.iter().collect());
        }
        let find = |name: &String| {
            let figure = FIGURES.iter().find(|f| f.name == name);
            figure.ok_or_else(|| {
                let names: Vec<&str> = FIGURES.iter().map(|f| f.name).collect();
                let problem = format!(
                    "no figure is called {name:?}; there are {}",
                    names.join(", ")
                );
                Error::invalid("--only", problem)
            })
        };
        self.only.iter().map(find).collect()
    }
}

fn print_verdict(verdict: &Verdict) {
    print(format_args!("{} ({:.1} s)", verdict.name, verdict.seconds));
    if let Some(error) = &verdict.error {
        print(format_args!("  not drawn: {error}"));
    }
    for check in &verdict.checks {
        let mark = if check.holds() { "holds" } else { "FAILS" };
        print(format_args!("  {mark}  {check}"));
    }
}

/// One bar at a time: that of what goes on.
#[derive(Default)]
struct Bars(Mutex<Option<(String, ProgressBar)>>);

impl Bars {
    fn show(&self, progress: Progress<'_>) {
        // A bar that panicked while it was drawn shows nothing more.
        let Ok(mut shown) = self.0.lock() else { return };
        if shown.as_ref().is_none_or(|(what, _)| what != progress.what) {
            if let Some((_, bar)) = shown.take() {
                bar.finish_and_clear();
            }
            let bar = bar(progress.of, progress.what);
            *shown = Some((progress.what.to_string(), bar));
        }
        if let Some((_, bar)) = &*shown {
            bar.set_position(progress.done as u64);
        }
        if progress.done >= progress.of
            && let Some((_, bar)) = shown.take()
        {
            bar.finish_and_clear();
        }
    }
}
