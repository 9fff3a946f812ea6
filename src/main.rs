//! The `supple` command.

fn main() -> std::process::ExitCode {
    supple::cli::main()
}
