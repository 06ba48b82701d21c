#![cfg(unix)]

use cosmic_lab::child::output;
use std::cell::Cell;
use std::process::Command;
use std::time::{Duration, Instant};

fn shell(program: &str, is_stopped: &dyn Fn() -> bool) -> Result<Option<Vec<u8>>, String> {
    output(Command::new("bash").args(["-c", program]), is_stopped)
}

#[test]
fn a_program_may_print_more_than_pipes_hold() {
    // A program that still runs after a minute is stopped, so that the test fails instead of hanging.
    let began = Instant::now();
    let is_late = || began.elapsed() > Duration::from_secs(60);
    let much = "head -c 3000000 /dev/zero | tr '\\0' x";
    let both = format!("{much} >&2; {much}; {much} >&2");
    let out = shell(&both, &is_late).unwrap().expect("it ends");
    assert_eq!(out, vec![b'x'; 3_000_000]);
    let fails = format!("{much}; {much} >&2; echo; echo reason >&2; exit 1");
    let error = shell(&fails, &is_late).unwrap_err();
    assert!(error.ends_with("reason"), "a long message");
}

#[test]
fn a_program_is_stopped_while_it_prints() {
    let looks = Cell::new(0);
    let is_stopped = || {
        looks.set(looks.get() + 1);
        looks.get() > 3
    };
    assert_eq!(shell("while true; do echo x; done", &is_stopped), Ok(None));
}
