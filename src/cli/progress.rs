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
