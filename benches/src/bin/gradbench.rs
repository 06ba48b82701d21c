//! The tool that GradBench runs. This is the same program as `adbench`.

use std::process::ExitCode;

fn main() -> ExitCode {
    benches::driver::main()
}
