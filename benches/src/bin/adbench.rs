//! Solves ADBench's problems from the command line. This is the same program as `gradbench`.

use std::process::ExitCode;

fn main() -> ExitCode {
    benches::driver::main()
}
