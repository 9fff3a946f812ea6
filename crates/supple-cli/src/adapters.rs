//! `supple adapters`.

use super::terminal::{print, print_json};
use serde_json::json;
use supple::Result;
use supple::gpu::adapters;

/// Arguments of `supple adapters`.
#[derive(clap::Args)]
pub struct Arguments {
    /// JSON in place of a list.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    /// Lists.
    pub fn run(self) -> Result<()> {
        let adapters = pollster::block_on(adapters());
        if self.json {
            let entry = |a: &supple::gpu::AdapterDescription| {
                let kind = format!("{:?}", a.kind).to_lowercase();
                json!({"name": a.name, "backend": a.backend, "kind": kind, "driver": a.driver})
            };
            return print_json(&adapters.iter().map(entry).collect::<Vec<_>>());
        }
        for a in &adapters {
            print(format_args!(
                "{} ({}, {:?}, {})",
                a.name, a.backend, a.kind, a.driver
            ));
        }
        if adapters.is_empty() {
            print("none; a driver such as mesa-vulkan-drivers brings a software one");
        }
        Ok(())
    }
}
