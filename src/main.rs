//! The command `shutterlab`.

use std::process::ExitCode;

fn main() -> ExitCode {
    shutterlab::cli::main()
}
