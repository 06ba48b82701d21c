//! The program `cosmic-gpu`.

use std::process::{Command, Output};

use crate::device;

/// Runs the program on the adapter with this name, or on the first one.
fn cosmic_gpu(line: &str, adapter: Option<&str>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosmic-gpu"));
    command.args(line.split_whitespace());
    if let Some(name) = adapter {
        command.args(["--device", name]);
    }
    command.output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn an_unknown_adapter_is_refused() {
    let done = cosmic_gpu("bench earth", Some("no such adapter"));
    assert_eq!(done.status.code(), Some(2));
    let error = text(&done.stderr);
    assert!(error.contains("there is no GPU to run on"), "{error}");
}

#[test]
fn devices_are_listed_and_measured() {
    let Some(gpu) = device::gpu() else { return };
    let name = &gpu.adapter().name;
    let listed = text(&cosmic_gpu("devices", None).stdout);
    assert!(listed.contains(name), "{listed}");
    let line = "bench stability --robots 2 --steps 8";
    let done = cosmic_gpu(line, Some(name));
    let measured = text(&done.stdout);
    println!("{measured}");
    assert!(done.status.success(), "{}", text(&done.stderr));
    for work in [
        "forward",
        "gradients of designs",
        "gradients of controllers",
    ] {
        let row = measured.lines().find(|row| row.contains(work)).expect(work);
        let rate = row.split('|').nth(4).expect(row).trim();
        assert!(rate.parse::<f64>().expect(row) > 0.0, "{row}");
    }
}
