//! Standard output that takes nothing, disks that are full.

use super::folder;
use std::fs::{File, OpenOptions};
use std::path::Path;
use std::process::{Command, Stdio};

const SUPPLE: &str = env!("CARGO_BIN_EXE_supple");

/// Writes to it fail, as on a full disk; not every system has it.
fn full() -> Option<File> {
    OpenOptions::new().write(true).open("/dev/full").ok()
}

/// A pipe that nobody reads.
fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

/// Exit code and what is on stderr.
fn with_stdout(folder: &Path, arguments: &[&str], stdout: Stdio) -> (Option<i32>, String) {
    let mut command = Command::new(SUPPLE);
    command.current_dir(folder).args(arguments);
    let output = command.stdout(stdout).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), stderr)
}

#[test]
fn what_nobody_takes_is_an_error() {
    let folder = folder();
    let path = folder.path();
    let sample = ["sample", "grasp", "-o", "here"];
    for arguments in [
        &["inspect", "limb.txt"][..],
        &["--help"],
        &["--version"],
        &sample,
    ] {
        let mut outputs = vec![closed()];
        outputs.extend(full().map(Stdio::from));
        for stdout in outputs {
            let (code, stderr) = with_stdout(path, arguments, stdout);
            assert_eq!(code, Some(1), "{arguments:?}: {stderr}");
            assert!(stderr.contains("error: standard output"), "{stderr}");
        }
        let (code, stderr) = with_stdout(path, arguments, Stdio::null());
        assert_eq!((code, &*stderr), (Some(0), ""), "{arguments:?}");
    }
    // What it writes into files is there.
    assert!(path.join("here/grasp.jsonl").exists());
}

#[test]
fn errors_that_nobody_hears_have_their_code() {
    let folder = folder();
    for arguments in [&["inspect", "nowhere.txt"][..], &["frobnicate"]] {
        let mut outputs = vec![closed()];
        outputs.extend(full().map(Stdio::from));
        for stderr in outputs {
            let mut command = Command::new(SUPPLE);
            command.current_dir(folder.path()).args(arguments);
            let status = command.stderr(stderr).status().unwrap();
            let expected = if arguments.len() == 1 { 2 } else { 1 };
            assert_eq!(status.code(), Some(expected), "{arguments:?}");
        }
    }
}

/// A file that may not grow over some kilobytes stands for a disk that is full.
#[test]
fn a_full_disk_leaves_what_was_there() {
    let folder = folder();
    let path = folder.path();
    let before = std::fs::read(path.join("limb.txt")).unwrap();
    let limited = |limit: &str| {
        let script = format!("trap '' XFSZ; ulimit -f {limit}; exec \"$0\" sample limb -o .");
        Command::new("sh")
            .current_dir(path)
            .args(["-c", &script, SUPPLE])
            .output()
            .unwrap()
    };
    let output = limited("4");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("limb.txt"), "{stderr}");
    assert!(std::fs::read(path.join("limb.txt")).unwrap() == before);
    let mut names: Vec<String> = std::fs::read_dir(path)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["limb.txt", "tiny.toml"]);
    assert!(limited("unlimited").status.success());
    assert!(std::fs::read(path.join("limb.txt")).unwrap() != before);
}
