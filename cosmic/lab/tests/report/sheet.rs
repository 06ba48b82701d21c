use cosmic::verdict::{Item, Level};
use cosmic_lab::report::sheet::{Section, Sheet};
use cosmic_lab::table::{Standing, Table};

#[test]
fn a_failed_row_is_marked_on_the_page_and_in_text() {
    let table = Table::of("errors", "Errors", &["one, <two>", "none"])
        .column("method", "what was done", |name| *name)
        .mark(Standing::Default, |name| name.starts_with("one"))
        .mark(Standing::Failed, |name| *name == "none")
        .done();
    let sheet = Sheet {
        title: "T".to_owned(),
        subject: "s".to_owned(),
        sections: vec![Section {
            verdict: vec![Item::limit("it <holds>", Level::Bad)],
            notes: vec!["Read `this`.".to_owned()],
            tables: vec![table],
            ..Section::default()
        }],
    };
    let page = sheet.to_html();
    assert!(page.contains("<tr class=\"failed\">") && page.contains("one, &lt;two&gt;"));
    assert!(page.contains("Read <code>this</code>.") && !page.contains('`'));
    assert!(page.contains("<li class=\"bad\">it &lt;holds&gt;</li>") && page.contains("<details>"));
    let verdict = sheet.verdict_text(|answer| answer.text.clone());
    assert_eq!(verdict, "T: s\n\nit <holds>\n: 0 checks, 0 failed\n");
    let text = sheet.to_text();
    assert!(text.starts_with(&verdict));
    let line = |word: &str| text.lines().find(|line| line.contains(word)).unwrap();
    assert!(line("none").starts_with("! ") && line("<two>").starts_with("* "));
}
