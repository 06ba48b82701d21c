use cosmic_lab::table::{Cell, Column, Emphasis, Table};

fn table() -> Table {
    let rows = [
        ("one, <two>", 3.into(), 0.1 + 0.2),
        ("none", Cell::Missing, f64::NAN),
    ];
    Table::of("errors", "Errors", &rows)
        .column("method", "what was done", |row| row.0)
        .column("steps", "how many", |row| row.1.clone())
        .column("error", "of `x`, m", |row| row.2)
        .mark(Emphasis::Default, |row| row.0 != "none")
        .mark(Emphasis::Failed, |row| row.0 == "none")
        .done()
}

#[test]
fn csv_keeps_every_digit_and_quotes() {
    assert_eq!(
        table().to_csv(),
        "method,steps,error\n\"one, <two>\",3,0.30000000000000004\nnone,,NaN\n"
    );
}

#[test]
fn json_names_the_numbers() {
    let json = table().to_json();
    let rows = &json["rows"];
    assert_eq!(rows[0]["error"], 0.1 + 0.2);
    assert!(rows[1]["error"].is_null() && rows[1]["steps"].is_null());
    let columns = json["columns"].as_object().unwrap().keys();
    assert!(columns.eq(rows[0].as_object().unwrap().keys()));
}

#[test]
fn html_has_escaped_cells_and_marked_rows() {
    let page = table().to_html();
    assert!(page.contains("<tr class=\"failed\">") && page.contains("one, &lt;two&gt;"));
    assert!(page.contains("title=\"of x, m\"") && page.contains("number\">0.3</td>"));
}

#[test]
fn text_has_the_decimals_of_its_columns() {
    let number = Column::new("b", "").unit("m").decimals(2, "–");
    let table = Table::of("", "", &[Some(-1.0), None])
        .column("a", "", |_| "x")
        .add(number, |x| *x)
        .done();
    assert_eq!(table.to_csv(), "a,b\nx,-1\nx,\n");
    assert_eq!(table.to_text(), "a   b, m\nx  -1.00\nx      –\n");
}
