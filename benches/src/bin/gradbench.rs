//! The tool of GradBench. The same program as `adbench`.

use std::process::ExitCode;

fn main() -> ExitCode {
    benches::driver::main()
}
