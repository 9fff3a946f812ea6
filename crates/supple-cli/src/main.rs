//! The `supple` command.

fn main() -> std::process::ExitCode {
    supple_cli::main()
}
