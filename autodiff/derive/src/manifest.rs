//! The name that a user's manifest gives to the crate `autodiff`.

/// Returns the name that the user's manifest gives to the package, if it gives one.
pub(crate) fn dependency() -> Option<String> {
    let folder = std::env::var_os("CARGO_MANIFEST_DIR")?;
    let manifest = std::fs::read_to_string(std::path::Path::new(&folder).join("Cargo.toml"));
    renamed(&manifest.ok()?)
}

/// Finds the package in the text of a manifest: `name = { package = "cosmic-autodiff" }` on one line, or this line in a
/// section `[dependencies.name]`. If it has several names, prefers the usual one.
fn renamed(manifest: &str) -> Option<String> {
    let (mut section, mut found) = ("", None);
    for line in manifest.lines().map(str::trim) {
        if let Some(header) = line.strip_prefix('[') {
            section = header.trim_end_matches(']');
        }
        let words: String = line.split_whitespace().collect();
        if line.starts_with('#') || !words.contains("package=\"cosmic-autodiff\"") {
            continue;
        }
        let name = match words.starts_with("package=") {
            true => section.rsplit_once("dependencies.")?.1,
            false => words.split_once('=')?.0,
        };
        let name = name.trim_matches('"').replace('-', "_");
        if name == "autodiff" || found.is_none() {
            found = Some(name);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::renamed;

    #[test]
    fn the_manifest_may_rename_the_package() {
        let of = |manifest: &str| renamed(manifest);
        let line = "[dependencies]\nrand = \"1\"\nad-core = { version = \"0.1\", package = \"cosmic-autodiff\" }";
        assert_eq!(of(line).as_deref(), Some("ad_core"));
        let section = "[package]\nname = \"x\"\n[dependencies.ad]\npackage = \"cosmic-autodiff\"\npath = \"..\"";
        assert_eq!(of(section).as_deref(), Some("ad"));
        let both = format!("{line}\nautodiff = {{ package=\"cosmic-autodiff\" }}");
        assert_eq!(of(&both).as_deref(), Some("autodiff"));
        assert_eq!(of("[dependencies]\ncosmic-autodiff = \"0.1\""), None);
        // The package of programs is another one, before or after this one.
        let programs = "steps = { package = \"cosmic-autodiff-programs\", path = \"..\" }";
        assert_eq!(of(&format!("[dependencies]\n{programs}")), None);
        for pair in [
            format!("{line}\n{programs}"),
            line.replace("rand = \"1\"", programs),
        ] {
            assert_eq!(of(&pair).as_deref(), Some("ad_core"), "{pair}");
        }
    }
}
