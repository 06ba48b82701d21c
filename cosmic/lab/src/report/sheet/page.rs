//! A sheet as one page of HTML that fetches nothing.

use std::fmt::Write;

use super::text::shown;
use super::{Cell, Row, Section, Sheet, Standing, Table};
use crate::report::page::wrap;
use crate::report::svg::escape;

/// Wide tables scroll; rows stand out.
const STYLE: &str = "<style>.wide { overflow-x: auto; } .wide td, .wide th { padding-right: 18px; }\n\
    tr.default td { background: #eaf3fb; font-weight: 600; }\n\
    tr.failed td { background: #fdecea; color: #a3260b; }</style>\n";

pub(super) fn render(sheet: &Sheet) -> String {
    let mut body = format!(
        "{STYLE}<h1>{}</h1>\n<p class=\"muted\">{}</p>\n",
        escape(&sheet.title),
        escape(&sheet.subject)
    );
    for part in &sheet.sections {
        body += &section(part);
    }
    body += "<p class=\"muted\">Blue rows: the scene as it stands. Red rows failed. Hover over a \
             column's heading for what it is.</p>\n";
    wrap(&sheet.title, &body)
}

fn section(section: &Section) -> String {
    let mut html = format!("<h2>{}</h2>\n", escape(&section.title));
    let (checks, failed) = (section.checks, section.failures.len());
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(html, "<p><b>{checks} checks, {failed} failed.</b></p>");
    for failure in &section.failures {
        let _ = writeln!(html, "<p>Failed: {}</p>", escape(failure));
    }
    for note in &section.notes {
        let _ = writeln!(html, "<p>{}</p>", escape(note));
    }
    for figure in &section.figures {
        let caption = escape(&figure.caption);
        let _ = writeln!(html, "{}<p class=\"muted\">{caption}</p>", figure.svg);
    }
    for part in &section.tables {
        html += &table(part);
    }
    html
}

fn table(table: &Table) -> String {
    let title = escape(&table.title);
    let mut html = format!("<p><b>{title}</b></p>\n<div class=\"wide\"><table><thead><tr>");
    for column in &table.columns {
        let (says, name) = (escape(&column.says), escape(&column.name));
        let _ = write!(html, "<th title=\"{says}\">{name}</th>");
    }
    html += "</tr></thead><tbody>\n";
    for part in &table.rows {
        html += &row(part);
    }
    html + "</tbody></table></div>\n"
}

fn row(row: &Row) -> String {
    let class = match row.standing {
        Standing::Plain => "",
        Standing::Default => " class=\"default\"",
        Standing::Failed => " class=\"failed\"",
    };
    let cell = |cell: &Cell| {
        let number = match cell {
            Cell::Text(_) => "",
            _ => " class=\"number\"",
        };
        format!("<td{number}>{}</td>", escape(&shown(cell)))
    };
    let cells: String = row.cells.iter().map(cell).collect();
    format!("<tr{class}>{cells}</tr>\n")
}
