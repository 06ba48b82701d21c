//! Tells the crate which SIMD registers the target has, and whether the crate is built without optimisation.

use std::env::var;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(unoptimised)");
    if var("OPT_LEVEL").is_ok_and(|level| level == "0") {
        println!("cargo::rustc-cfg=unoptimised");
    }
    println!("cargo::rustc-check-cfg=cfg(lanes, values(none(), \"x86\", \"neon\", \"simd128\"))");
    if let Some(lanes) = lanes() {
        println!("cargo::rustc-cfg=lanes");
        println!("cargo::rustc-cfg=lanes=\"{lanes}\"");
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
