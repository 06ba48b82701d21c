//! Tells the crate which SIMD registers its lanes have.

use std::env::var;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(lanes, values(none(), \"x86\", \"neon\", \"simd128\"))");
    println!("cargo::rustc-check-cfg=cfg(lanes_512)");
    println!("cargo::rustc-check-cfg=cfg(lanes_f32)");
    let level = var("OPT_LEVEL").unwrap_or_default();
    // Without optimisation every intermediate value of inlined code has its own place on the stack. With wide registers
    // a kernel would need megabytes of stack. `--cfg unoptimised` in RUSTFLAGS also asks for scalars.
    if level == "0" || var("CARGO_CFG_UNOPTIMISED").is_ok() {
        return;
    }
    if let Some(lanes) = lanes() {
        println!("cargo::rustc-cfg=lanes");
        println!("cargo::rustc-cfg=lanes=\"{lanes}\"");
        // Each kernel is compiled once more for each of these kinds of registers. Test builds, which have level 1, save
        // this time. AVX-512 makes gradients of programs 10 to 30 % faster.
        if level != "1" {
            println!("cargo::rustc-cfg=lanes_f32");
        }
        if lanes == "x86" && level != "1" {
            println!("cargo::rustc-cfg=lanes_512");
        }
    }
}

fn lanes() -> Option<&'static str> {
    let target = |name: &str| var(format!("CARGO_CFG_TARGET_{name}")).unwrap_or_default();
    let features = target("FEATURE");
    let has = |feature| features.split(',').any(|one| one == feature);
    match target("ARCH").as_str() {
        "x86_64" => Some("x86"),
        "aarch64" if has("neon") && target("ENDIAN") == "little" => Some("neon"),
        "wasm32" if has("simd128") => Some("simd128"),
        _ => None,
    }
}
