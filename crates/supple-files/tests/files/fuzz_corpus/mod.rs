//! Every parser against thousands of damaged files: it answers, with a value or an error, in bounded time and
//! memory. The same damage every time; `fuzz/` has the open-ended search over the same parsers.

mod formats;
mod memory;
mod mutate;
mod seeds;

use formats::Format;
use memory::peak_during;
use mutate::Mutations;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

/// Damaged files of each format.
const CASES: usize = 10_000;

/// Most bytes that a parse may hold at once: so many, and so many for each byte of the file. A deflated byte
/// becomes a thousand, and one of them a number of eight.
const MOST_BYTES: (usize, usize) = (16 << 20, 1000);

/// Longest that a parse of a file of some kilobytes may take, on a machine that is busy.
const LONGEST: Duration = Duration::from_secs(5);

/// One case: whether the file was accepted; panics, naming the case, where a bound is broken.
fn check(format: &Format, bytes: &[u8], case: &str) -> bool {
    let bytes = (format.wrap)(bytes.to_vec());
    let start = Instant::now();
    let (result, peak) = peak_during(|| catch_unwind(AssertUnwindSafe(|| (format.parse)(&bytes))));
    let most = MOST_BYTES.0 + MOST_BYTES.1 * bytes.len();
    let problem = match &result {
        Err(_) => "panics".to_string(),
        Ok(_) if peak > most => format!("holds {peak} bytes"),
        Ok(_) if start.elapsed() > LONGEST => format!("takes {:?}", start.elapsed()),
        Ok(accepted) => return *accepted,
    };
    let path =
        std::env::temp_dir().join(format!("supple_{}_{}", format.name, case.replace(' ', "_")));
    let kept = std::fs::write(&path, &bytes).map_or(String::new(), |()| path.display().to_string());
    panic!("{}, {case}: {problem}; the file: {kept}", format.name);
}

fn run(format: &Format) {
    let mut accepted = 0;
    for (s, seed) in format.seeds.iter().enumerate() {
        assert!(
            check(format, seed, &format!("seed {s}")),
            "{}: seed {s} is refused",
            format.name
        );
    }
    let mutations = Mutations::new(&format.seeds, CASES);
    for (case, bytes) in mutations.enumerate() {
        accepted += usize::from(check(format, &bytes, &format!("case {case}")));
    }
    println!(
        "{}: {accepted} of {CASES} damaged files were accepted",
        format.name
    );
    assert!(accepted < CASES, "{}: nothing was damaged", format.name);
}

macro_rules! formats {
    ($($name:ident),+ $(,)?) => {
        $(#[test]
        fn $name() {
            run(&formats::$name());
        })+
    };
}

formats!(
    smpl_npz,
    smpl_npy_inside,
    pickle,
    obj,
    gltf,
    gltf_motions,
    gltf_meshopt,
    meshopt_inside,
    gltf_painted,
    tets,
    tetgen,
    bvh,
    amass,
    amass_npy_inside,
    series,
    pose,
    pose_stream,
    baked,
    scene,
    recipe,
);

#[cfg(feature = "draco")]
formats!(gltf_draco, draco_inside);

/// The check sees what it is there for.
#[test]
fn a_parser_that_breaks_a_bound_is_caught() {
    let of = |parse: fn(&[u8]) -> bool| Format {
        name: "broken",
        seeds: vec![vec![1; 8]],
        wrap: |bytes| bytes,
        parse,
    };
    let caught = |parse| catch_unwind(|| check(&of(parse), &[1; 8], "case 0")).is_err();
    assert!(caught(|bytes| bytes[100] == 0));
    assert!(caught(|bytes| vec![1u8; 20_000_000 * bytes.len()]
        .iter()
        .all(|b| *b == 1)));
    assert!(!caught(|bytes| bytes.len() == 8));
}

/// Where cargo-fuzz looks for files to start from.
const CORPUS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus");

/// The same files as a start for cargo-fuzz.
#[test]
#[ignore = "writes fuzz/corpus, for `cargo fuzz run`"]
fn write_seeds() {
    let of_targets = [
        ("smpl", formats::smpl_npz()),
        ("smpl", formats::pickle()),
        ("npy", formats::amass_npy_inside()),
        ("obj", formats::obj()),
        ("gltf", formats::gltf()),
        ("gltf", formats::gltf_meshopt()),
        ("gltf", formats::gltf_painted()),
        #[cfg(feature = "draco")]
        ("draco", formats::draco_inside()),
        ("meshopt", formats::meshopt_inside()),
        ("tets", formats::tets()),
        ("tetgen", formats::tetgen()),
        ("bvh", formats::bvh()),
        ("amass", formats::amass()),
        ("pose", formats::pose()),
        ("pose_stream", formats::pose_stream()),
        ("baked", formats::baked()),
        ("scene", formats::scene()),
        ("scene", formats::recipe()),
    ];
    for (target, format) in of_targets {
        let folder = Path::new(CORPUS).join(target);
        std::fs::create_dir_all(&folder).unwrap();
        for (i, seed) in format.seeds.iter().enumerate() {
            // The target writes the baked file's header itself.
            let seed = if target == "baked" { &seed[24..] } else { seed };
            std::fs::write(folder.join(format!("{}_{i}", format.name)), seed).unwrap();
        }
    }
}
