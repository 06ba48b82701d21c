//! The name that a user's manifest gives to a crate.

use crate::tokens::{Refusal, TokenStream as Code, TokenTree, code, is, is_punct, parts};

/// Returns the path of the crate of a package in the user's code: that of an attribute `#[autodiff(crate = "path")]`, or the
/// name in the manifest, or the usual one.
pub(crate) fn root(package: &str, attributes: &[Vec<TokenTree>]) -> Result<Code, Refusal> {
    let mut root = None;
    for attribute in attributes {
        let [name, TokenTree::Group(group)] = &attribute[..] else {
            continue;
        };
        if !is(name, "autodiff") {
            continue;
        }
        let tokens: Vec<TokenTree> = group.stream().into_iter().collect();
        for entry in parts(&tokens, ',') {
            let path = match entry {
                [key, equals, TokenTree::Literal(path)]
                    if is(key, "crate") && is_punct(equals, '=') =>
                {
                    path.to_string()
                }
                _ => String::new(),
            };
            let path = path
                .strip_prefix('"')
                .and_then(|path| path.strip_suffix('"'));
            let Some(path) = path.and_then(|path| path.parse().ok()) else {
                let why = "unknown key; expected `crate = \"path\"`";
                let at = entry.first().map_or(group.span(), TokenTree::span);
                return Err(Refusal(at, why.into()));
            };
            root = Some(path);
        }
    }
    Ok(root.unwrap_or_else(|| {
        let name = dependency(package).unwrap_or_else(|| usual(package));
        code(&format!("::{name}"))
    }))
}

/// Returns the name that the user's manifest gives to this package, if it gives one.
fn dependency(package: &str) -> Option<String> {
    let folder = std::env::var_os("CARGO_MANIFEST_DIR")?;
    let manifest = std::fs::read_to_string(std::path::Path::new(&folder).join("Cargo.toml"));
    renamed(&manifest.ok()?, package)
}

/// Finds the package in the text of a manifest: `name = { package = "cosmic-autodiff" }` on one line, or this line in a
/// section `[dependencies.name]`. If it has several names, prefers the usual one, which lacks the prefix `cosmic-`.
fn renamed(manifest: &str, package: &str) -> Option<String> {
    let (mut section, mut found) = ("", None);
    let wanted = format!("package=\"{package}\"");
    for line in manifest.lines().map(str::trim) {
        if let Some(header) = line.strip_prefix('[') {
            section = header.trim_end_matches(']');
        }
        let words: String = line.split_whitespace().collect();
        if line.starts_with('#') || !words.contains(&wanted) {
            continue;
        }
        let name = match words.starts_with("package=") {
            true => section.rsplit_once("dependencies.")?.1,
            false => words.split_once('=')?.0,
        };
        let name = name.trim_matches('"').replace('-', "_");
        if name == usual(package) || found.is_none() {
            found = Some(name);
        }
    }
    found
}

/// The usual name of a package in code.
fn usual(package: &str) -> String {
    package.trim_start_matches("cosmic-").replace('-', "_")
}

#[cfg(test)]
mod tests {
    use super::renamed;

    #[test]
    fn the_manifest_may_rename_the_package() {
        let of = |manifest: &str| renamed(manifest, "cosmic-autodiff");
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
            let programs = renamed(&pair, "cosmic-autodiff-programs");
            assert_eq!(programs.as_deref(), Some("steps"), "{pair}");
        }
    }
}
