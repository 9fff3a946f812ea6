//! Progress bars, on stderr and only where that is a terminal.

use crate::bake::PHASES;
use indicatif::{ProgressBar, ProgressStyle};

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

/// A bar over a bake's phases, and what tells it the phase.
pub fn baking(name: &str) -> impl FnMut(usize) {
    let bar = bar(PHASES.len(), name);
    move |phase| {
        bar.set_position(phase as u64);
        match PHASES.get(phase) {
            Some(name) => bar.set_message(*name),
            None => bar.finish_and_clear(),
        }
    }
}
