//! `supple figures`: the gallery is a program of its own, since nobody who bakes and simulates needs it.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;
use supple::{Error, Result};

/// The gallery's program, built and installed from the folder `lab`.
const PROGRAM: &str = "supple-figures";

/// Arguments of `supple figures`.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub struct Arguments {
    /// What `supple-figures` is told.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

impl Arguments {
    /// Runs the program that stands beside this one or on the PATH.
    pub fn run(self) -> Result<()> {
        let beside = std::env::current_exe().ok().map(|own| {
            let name = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
            own.with_file_name(name)
        });
        let program = (beside.filter(|p| p.exists())).unwrap_or_else(|| PathBuf::from(PROGRAM));
        let status = Command::new(&program).args(self.arguments).status();
        let status = status.map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => {
                let problem =
                    format!("{PROGRAM} is not installed; in a checkout: cargo install --path lab");
                Error::invalid("figures", problem)
            }
            _ => Error::io(&program, e),
        })?;
        if status.success() {
            return Ok(());
        }
        // It has said why.
        std::process::exit(status.code().unwrap_or(1))
    }
}
