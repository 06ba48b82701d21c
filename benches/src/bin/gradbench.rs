//! The tool that GradBench runs: it answers requests on standard input and output.

use std::io::{self, BufReader, BufWriter};

fn main() -> io::Result<()> {
    /// The size of a buffer in bytes. It is large, because one line may contain a whole model.
    const BUFFER: usize = 1 << 20;
    let lines = BufReader::with_capacity(BUFFER, io::stdin().lock());
    let replies = BufWriter::with_capacity(BUFFER, io::stdout().lock());
    benches::gradbench::serve(lines, replies)
}
