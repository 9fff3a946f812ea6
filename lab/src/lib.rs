//! The figures of the paper as scenes that are run, drawn and checked.
//!
//! A [`Figure`] draws itself on a [`Page`]: text, pictures, tables, curves, and [`Check`]s of its physics, each a
//! measured value with its bound. A [`Runner`] runs what it asks for. At [`Size::Small`] a figure takes seconds
//! and is a test (`cargo test -p supple-lab`); at [`Size::Full`] it is an entry of the gallery that
//! [`write_gallery`] makes (`supple figures`). Both run the same code, so no number in the gallery is typed in.
//!
//! A new figure is one file here and one line in [`FIGURES`].

mod awake;
mod bases;
mod bone_press;
mod check;
mod compression;
mod convergence;
mod cubature;
mod cylinders;
mod elastic_extension;
mod finger_slide;
mod gallery;
mod html;
mod jiggle;
mod layers;
mod lift;
mod measure;
mod page;
mod pin_press;
mod poses;
pub mod press;
mod press_anywhere;
mod ragdolls;
mod reduced_full;
mod rigid_soft;
mod runner;
mod skins;
mod slope;
mod spectrum;
mod spin;
mod stability;
mod static_poses;
mod sway;
mod table_1;
mod uniaxial;
mod walk;

pub use check::{Bound, Check};
pub use gallery::{Summary, Verdict, write_gallery};
pub use page::{Block, Page, Table};
pub use runner::{Progress, Runner, SeededPresses, Size};

use supple::Result;

/// A figure.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// What the command and the tests call it.
    pub name: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Which figure, table or section of the paper it stands for; empty where it goes beyond.
    pub paper: &'static str,
    /// Runs, draws and checks it.
    pub draw: fn(&Runner) -> Result<Page>,
}

/// Every figure, in the paper's order.
pub const FIGURES: &[Figure] = &[
    static_poses::FIGURE,
    rigid_soft::FIGURE,
    layers::FIGURE,
    spin::FIGURE,
    cylinders::FIGURE,
    walk::FIGURE,
    finger_slide::FIGURE,
    ragdolls::FIGURE,
    lift::FIGURE,
    cubature::FIGURE,
    reduced_full::FIGURE,
    table_1::FIGURE,
    bases::HAND,
    bases::CHEST,
    pin_press::FIGURE,
    convergence::FIGURE,
    stability::FIGURE,
    slope::FIGURE,
    jiggle::FIGURE,
    bone_press::FIGURE,
    compression::FIGURE,
    elastic_extension::FIGURE,
    press_anywhere::FIGURE,
    sway::FIGURE,
];
