use cosmic_lab::table::{Emphasis, Table};

#[test]
fn cells_come_from_the_subjects_and_the_last_mark_counts() {
    let table = Table::of("squares", "Squares", &[1.0, 2.0, 3.0])
        .column("x", "the number", |x| *x)
        .columns(["x2", "x3"], "a power", |x, k| x.powi(k as i32 + 2))
        .mark(Emphasis::Default, |x| *x > 1.0)
        .mark(Emphasis::Failed, |x| *x > 2.0)
        .done();
    assert_eq!(table.to_csv(), "x,x2,x3\n1,1,1\n2,4,8\n3,9,27\n");
    let emphases = table.rows.iter().map(|row| row.emphasis);
    assert!(emphases.eq([Emphasis::Plain, Emphasis::Default, Emphasis::Failed]));
    assert_eq!((&*table.name, &*table.title), ("squares", "Squares"));
}
