//! ADBench's problems from the command line. The same program as `gradbench`.

use std::process::ExitCode;

fn main() -> ExitCode {
    benches::driver::main()
}
