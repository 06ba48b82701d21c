use cosmic::judge::verdict::{Item, Level};
use cosmic_lab::report::sheet::{Chart, Line, Section, Sheet};
use cosmic_lab::table::{Emphasis, Table};

#[test]
fn a_failed_row_is_marked_on_the_page_and_charts_are_drawn() {
    let table = Table::of("errors", "Errors", &["one, <two>", "none"])
        .column("method", "what was done", |name| *name)
        .mark(Emphasis::Default, |name| name.starts_with("one"))
        .mark(Emphasis::Failed, |name| *name == "none")
        .done();
    let sheet = Sheet {
        title: "T".to_owned(),
        subject: "s".to_owned(),
        sections: vec![Section {
            title: "Part".to_owned(),
            text: "short\n".to_owned(),
            answers: vec![Item::limit("it <holds>", Level::Bad)],
            notes: vec!["Read `this`.".to_owned()],
            tables: vec![table],
            charts: vec![Chart {
                title: "error, <m>".to_owned(),
                along: "time, s".to_owned(),
                is_log: [true, true],
                lines: vec![Line::new("a < b", [[1.0, f64::NAN]].into_iter())],
            }],
            checks: 2,
            failures: vec!["none".to_owned()],
        }],
    };
    let page = sheet.to_html();
    assert!(page.contains("<tr class=\"failed\">") && page.contains("one, &lt;two&gt;"));
    assert!(page.contains("Read <code>this</code>."));
    assert!(page.contains("<li class=\"bad\">it &lt;holds&gt;</li>") && page.contains("<details>"));
    assert!(page.contains("aria-label=\"error, &lt;m&gt;\"") && page.contains("[1.0,null]"));
    let shown = |answer: &Item| answer.text.clone();
    assert_eq!(sheet.sections[0].to_text(shown), "short\nit <holds>\n");
    assert_eq!(sheet.outcomes(shown), "Part: 2 checks, 1 failed\n");
    let folder = tempfile::tempdir().unwrap();
    let written = sheet.write(folder.path()).unwrap();
    let names = written.iter().map(|path| path.file_name().unwrap());
    assert!(names.eq(["check.html", "errors.csv"]));
}
