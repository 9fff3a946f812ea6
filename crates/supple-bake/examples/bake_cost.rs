//! What a bake costs: CPU seconds by phase and peak memory, from the body in memory to the avatar in memory.
//!
//! `cargo run --release -p supple-bake --example bake_cost -- [hand | body | FILE]…` measures each in a process of its own;
//! without arguments the sample body and hand, and the characters of `../shared/assets` that are there. Each is baked
//! three times and the least of each phase printed: other programs only ever add. Linux alone tells these figures.

use std::error::Error;
use std::path::Path;
use std::process::Command;
use supple_bake::{Body, PHASES, Recipe, bake};
use supple_files::read_character;
use supple_samples::Sample;

const REPEATS: usize = 3;

/// Set in the processes that measure one body.
const ALONE: &str = "BAKE_COST_OF_ONE";

fn main() -> Result<(), Box<dyn Error>> {
    let mut asked: Vec<String> = std::env::args().skip(1).collect();
    if std::env::var_os(ALONE).is_some() {
        return asked.iter().try_for_each(|what| measure(what));
    }
    if asked.is_empty() {
        asked = ["body", "hand"].map(String::from).to_vec();
        let files = [
            "khronos-CesiumMan.glb",
            "makehuman-female-cmu-02_01.glb",
            "webxr-generic-hand-left.glb",
        ];
        let files = files.map(|file| format!("../shared/assets/{file}"));
        asked.extend(files.into_iter().filter(|file| Path::new(file).exists()));
    }
    println!("CPU seconds, phases in order: {}", PHASES.join(", "));
    for what in asked {
        let program = std::env::current_exe()?;
        let status = Command::new(program).arg(&what).env(ALONE, "1").status()?;
        if !status.success() {
            return Err(format!("{what}: {status}").into());
        }
    }
    Ok(())
}

fn measure(what: &str) -> Result<(), Box<dyn Error>> {
    let (body, recipe): (Body, Recipe) = match what {
        "hand" => Sample::Hand.body()?,
        "body" => Sample::Body.body()?,
        file => (
            read_character(file, &Default::default())?.body,
            Recipe::default(),
        ),
    };
    let mut least = [f64::INFINITY; PHASES.len()];
    let mut told = String::new();
    let mut peak = u64::MAX;
    for _ in 0..REPEATS {
        // From here on the kernel counts the peak anew.
        std::fs::write("/proc/self/clear_refs", "5")?;
        let mut times = Vec::new();
        let (avatar, report) = bake(&body, &recipe, &mut |_| times.push(cpu_seconds()))?;
        for (least, pair) in least.iter_mut().zip(times.windows(2)) {
            *least = least.min(pair[1] - pair[0]);
        }
        peak = peak.min(report.cost.peak_memory.unwrap_or(u64::MAX));
        told = format!(
            "{} nodes ({} free), {} tets, {} handles, {} points",
            report.mesh.quality.nodes,
            report.free_nodes,
            report.mesh.quality.tets,
            avatar.handles.len(),
            avatar.cubature.len()
        );
    }
    let name = Path::new(what).file_stem().unwrap_or_default();
    let phases: Vec<String> = least.iter().map(|s| format!("{s:.2}")).collect();
    println!(
        "{:<32} {:5.2} s = {}; peak {:.0} MB; {told}",
        name.display(),
        least.iter().sum::<f64>(),
        phases.join(" + "),
        peak as f64 / 1e6
    );
    Ok(())
}

/// CPU seconds of all threads that live; those of the pool live on.
fn cpu_seconds() -> f64 {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten();
    let nanoseconds = threads.flatten().filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    1e-9 * nanoseconds.sum::<f64>()
}
