//! GradBench's tool: answers the lines of its protocol on standard input.

use std::io::{self, BufReader, BufWriter};
use std::process::ExitCode;

use benches::gradbench::protocol::serve;

fn main() -> ExitCode {
    /// Lines are long: whole models in one.
    const BUFFER: usize = 1 << 20;
    let lines = BufReader::with_capacity(BUFFER, io::stdin().lock());
    let replies = BufWriter::with_capacity(BUFFER, io::stdout().lock());
    match serve(lines, replies) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("gradbench: {error}");
            ExitCode::FAILURE
        }
    }
}
