//! The pages in `tests/pages` show commands and what they print. Each page is a test: its commands are run in an empty
//! folder, and must print what the page shows.
//!
//! A block of a page whose first line is `console` has commands of the shell, each after `$ `. Lines that begin with `> `
//! continue a command. Below a command are its exit code, as `? 2`, unless it is 0, and its output. In the output, `[..]`
//! stands for any characters of a line, and a line `...` for any lines. A block whose first line also has a name, such as
//! `toml tiny.toml`, is a file for the commands below it. The other files in `tests/pages` are there from the start.
//!
//! With `SNAPSHOTS=overwrite`, the tests write what the commands print into the pages. Then no test fails, whatever the
//! commands print. So read every line that changed before you commit a page.

use snapbox::data::DataFormat;
use snapbox::filter::NormalizeToExpected;
use snapbox::{Assert, Data};
use std::env;
use std::ffi::OsString;
use std::fs;
use std::iter::Peekable;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::str::Lines;
use tempfile::TempDir;

/// Makes a test of each page.
macro_rules! pages {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                is_true(stringify!($name));
            }
        )*

        #[test]
        fn every_page_is_a_test() {
            let page = |path: &PathBuf| Some(path.file_name()?.to_str()?.strip_suffix(".md")?.to_owned());
            let mut pages: Vec<_> = all_files().iter().filter_map(page).collect();
            pages.sort();
            assert_eq!(pages, [$(stringify!($name)),*]);
        }
    };
}

pages! {
    check clock evaluate export files from gradients lattice optimize programs report resume robustness scene settings
    sweep tasks unstable usage walk
}

const END: &str = "```";

/// The folder of the pages.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pages")
}

/// The pages and the files beside them.
fn all_files() -> Vec<PathBuf> {
    let files = fs::read_dir(folder()).unwrap();
    files.map(|file| file.unwrap().path()).collect()
}

/// Asserts that the commands of a page print what the page shows, or writes what they print.
#[track_caller]
fn is_true(name: &str) {
    let path = folder().join(name).with_extension("md");
    let shown = fs::read_to_string(&path).unwrap();
    let expected = Data::read_from(&path, Some(DataFormat::Text)).raw();
    let assert = Assert::new().action_env("SNAPSHOTS");
    assert.eq(Page::told(&shown), expected);
}

/// A page whose commands are being run.
struct Page<'a> {
    /// The lines that were not read yet.
    lines: Peekable<Lines<'a>>,
    /// The lines that were read, with what the commands print.
    told: String,
    /// The folder in which the commands are run.
    folder: TempDir,
    /// The value of `PATH` for the commands. It has the folders of the program and of its examples.
    path: OsString,
}

impl<'a> Page<'a> {
    /// Runs the commands of a page. Returns the page with what they print.
    fn told(shown: &'a str) -> String {
        let built = Path::new(env!("CARGO_BIN_EXE_cosmic")).parent().unwrap();
        let programs = [built.to_owned(), built.join("examples")].into_iter();
        let path = env::var_os("PATH").unwrap_or_default();
        let mut page = Self {
            lines: shown.lines().peekable(),
            told: String::new(),
            folder: tempfile::tempdir().unwrap(),
            path: env::join_paths(programs.chain(env::split_paths(&path))).unwrap(),
        };
        let is_page = |file: &PathBuf| file.extension().is_some_and(|kind| kind == "md");
        for file in all_files().iter().filter(|file| !is_page(file)) {
            let copy = page.folder.path().join(file.file_name().unwrap());
            fs::copy(file, copy).unwrap();
        }
        while let Some(line) = page.line() {
            match line.strip_prefix(END) {
                Some("console") => while page.command() {},
                Some(block) => page.file(block),
                None => {}
            }
        }
        page.told
    }

    /// Reads a line and adds it to the result.
    fn line(&mut self) -> Option<&'a str> {
        self.line_if(|_| true)
    }

    fn line_if(&mut self, is_next: impl Fn(&str) -> bool) -> Option<&'a str> {
        let line = self.lines.next_if(|line| is_next(line))?;
        self.told += line;
        self.told += "\n";
        Some(line)
    }

    /// Reads a block that is not run. If its first line has a name, the block is a file.
    fn file(&mut self, block: &str) {
        let mut text = String::new();
        while let Some(line) = self.line().filter(|line| *line != END) {
            text += line;
            text += "\n";
        }
        if let Some((_, name)) = block.split_once(' ') {
            fs::write(self.folder.path().join(name), text).unwrap();
        }
    }

    /// Runs the next command of a block. Returns false at the end of the block.
    fn command(&mut self) -> bool {
        let line = self.line().filter(|line| *line != END);
        let Some(line) = line else { return false };
        let first = line.strip_prefix("$ ");
        // Both streams go into one pipe, so that their lines are in the order in which they were written.
        let mut script = format!("exec 2>&1\n{}", first.expect(line));
        while let Some(line) = self.line_if(|line| line.starts_with("> ")) {
            script += &format!("\n{}", &line[2..]);
        }
        let mut shown = String::new();
        let is_output = |line: &&str| !line.starts_with("$ ") && *line != END;
        while let Some(line) = self.lines.next_if(is_output) {
            shown += &format!("{line}\n");
        }
        let told = Data::text(self.run(&script));
        let redacted = NormalizeToExpected::new().redact();
        let told = redacted.normalize(told, &Data::text(shown));
        self.told += &told.render().unwrap();
        true
    }

    /// Runs a script. Returns its exit code, unless it is 0, and its output.
    fn run(&self, script: &str) -> String {
        let mut shell = Command::new("sh");
        shell.args(["-c", script]).current_dir(&self.folder);
        // `LC_ALL` determines the order in which the shell lists files.
        let output = shell.env("PATH", &self.path).env("LC_ALL", "C").output();
        let output = output.unwrap();
        let mut told = match output.status.code().expect("an exit code") {
            0 => String::new(),
            code => format!("? {code}\n"),
        };
        told += &String::from_utf8_lossy(&output.stdout);
        if !told.is_empty() && !told.ends_with('\n') {
            told += "\n";
        }
        told
    }
}
