//! poropunch's command line.

fn main() -> std::process::ExitCode {
    runner::cli::main()
}
