//! The program as a user has it, without a window: events go in, pictures come out, and are measured. Where there is no adapter
//! at all, each says so and is left out; a software one will do.

mod files;
mod picture;
mod touch;

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock};
use supple_samples::Sample;
use supple_view::{Button, Event, Offscreen, Options, PANEL_WIDTH, Picture, Request};

/// Pixels of a picture; the panel takes its part.
const SIZE: [u32; 2] = [690, 400];

/// One bake of the limb for all tests of this program.
fn cache() -> &'static Path {
    static CACHE: OnceLock<tempfile::TempDir> = OnceLock::new();
    CACHE.get_or_init(|| tempfile::tempdir().unwrap()).path()
}

/// One after the other: a bake serves all, and a software adapter takes all cores.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(|e| e.into_inner())
}

/// The program with nobody in it; none where there is no adapter.
fn empty(on_gpu: bool) -> Option<Offscreen> {
    with_options(Options {
        on_gpu,
        ..Options::default()
    })
}

/// The same with these options, and folders of the tests.
fn with_options(options: Options) -> Option<Offscreen> {
    let options = Options {
        cache: Some(cache().into()),
        output: cache().join("written"),
        ..options
    };
    match Offscreen::open(options, SIZE) {
        Ok(mut view) => {
            // The first layout says how large the scene is.
            view.picture().unwrap();
            Some(view)
        }
        Err(e) => {
            println!("left out: {e}");
            None
        }
    }
}

/// A limb of one bone, which stands and sways.
fn limb(on_gpu: bool) -> Option<Offscreen> {
    let mut view = empty(on_gpu)?;
    view.show(Request::Sample(Sample::LimbS)).unwrap();
    Some(view)
}

/// The scene's part of a picture: width and height.
fn scene() -> [u32; 2] {
    [SIZE[0] - PANEL_WIDTH as u32, SIZE[1]]
}

/// The middle of the scene, pixels.
fn middle() -> [f64; 2] {
    scene().map(|n| 0.5 * f64::from(n))
}

fn drag(view: &mut Offscreen, from: [f64; 2], to: [f64; 2], button: Button) {
    view.handle(Event::Moved(from));
    view.handle(Event::Button(button, true));
    for k in 1..=10 {
        let part = f64::from(k) / 10.0;
        view.handle(Event::Moved(
            [0, 1].map(|i| from[i] + part * (to[i] - from[i])),
        ));
        view.run(1.0 / 60.0);
    }
}

/// How many pixels of the scene differ between two pictures by more than a hair.
fn differing(a: &Picture, b: &Picture) -> usize {
    let [width, height] = scene();
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let apart = |&(x, y): &(u32, u32)| {
        let pairs = a.at(x, y).into_iter().zip(b.at(x, y));
        pairs.map(|(p, q)| p.abs_diff(q)).max() > Some(24)
    };
    places.filter(apart).count()
}

/// Keeps a picture for who wants to look at it: where SUPPLE_PICTURES names a folder.
fn keep(picture: &Picture, name: &str) {
    if let Some(folder) = std::env::var_os("SUPPLE_PICTURES") {
        let folder = PathBuf::from(folder);
        std::fs::create_dir_all(&folder).unwrap();
        picture
            .write_png(&folder.join(format!("{name}.png")))
            .unwrap();
    }
}
