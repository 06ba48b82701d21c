//! The flat pattern as a DXF file of release 12, which every program for laser cutters reads. A file consists of pairs
//! of lines: a code and a value. Release 12 cannot say in which unit its numbers are; in this file they are in
//! millimetres.

use super::pattern::{LABEL, Part, Pattern};
use cosmic::geometry::Vector;
use std::fmt::{Display, Write};

/// The name of the drawing's layer that holds the labels.
const LABELS: &str = "LABELS";

/// Colour numbers of DXF: 7 is black on white paper, 5 is blue, 3 is green.
const SKELETON: u8 = 7;
const ACTUATOR: u8 = 5;
const GREEN: u8 = 3;

/// A drawing under construction.
#[derive(Default)]
struct Dxf(String);

impl Dxf {
    fn pair(&mut self, code: u16, value: impl Display) {
        // Writing to a string cannot fail.
        let _ = write!(self.0, "{code}\r\n{value}\r\n");
    }

    /// Begins an entity or a vertex: writes its type `name`, its layer and its position.
    fn begin(&mut self, name: &str, layer: &str, place: Vector<f64>) {
        self.pair(0, name);
        self.pair(8, layer);
        self.place(10, place);
        self.pair(30, "0.0");
    }

    /// Writes the two coordinates of a point, rounded to a nanometre. The code of the first is `code`. The code of the
    /// second is `code + 10`.
    fn place(&mut self, code: u16, place: Vector<f64>) {
        let [x, y] = place.array();
        self.pair(code, format_args!("{x:.6}"));
        self.pair(code + 10, format_args!("{y:.6}"));
    }

    fn section(&mut self, name: &str, fill: impl FnOnce(&mut Self)) {
        self.pair(0, "SECTION");
        self.pair(2, name);
        fill(self);
        self.pair(0, "ENDSEC");
    }

    fn circle(&mut self, layer: &str, middle: Vector<f64>, diameter: f64) {
        self.begin("CIRCLE", layer, middle);
        self.pair(40, format_args!("{:.6}", 0.5 * diameter));
    }

    /// Draws the outline of a bar as a closed line. DXF writes a half circle as a segment with a "bulge" of 1.
    fn outline(&mut self, layer: &str, part: &Part) {
        self.begin("POLYLINE", layer, Vector::zero());
        self.pair(66, 1);
        self.pair(70, 1);
        for (corner, bulge) in part.corners.into_iter().zip([0, 1, 0, 1]) {
            self.begin("VERTEX", layer, corner);
            self.pair(42, bulge);
        }
        self.pair(0, "SEQEND");
        self.pair(8, layer);
    }

    /// Draws a text whose middle is at `place`.
    fn text(&mut self, place: Vector<f64>, height: f64, angle: f64, text: &str) {
        self.begin("TEXT", LABELS, place);
        self.pair(40, format_args!("{height:.6}"));
        self.pair(1, text);
        self.pair(50, format_args!("{angle:.6}"));
        self.pair(72, 1);
        self.pair(73, 2);
        self.place(11, place);
        self.pair(31, "0.0");
    }
}

/// Returns the name of the drawing's layer for the bars of one material in one layer of the pattern. The argument
/// `layer` counts from 0.
fn name(layer: usize, is_actuator: bool) -> String {
    let material = if is_actuator { "ACTUATOR" } else { "SKELETON" };
    format!("L{}_{material}", layer + 1)
}

/// Returns the pattern as the text of a DXF file.
pub(super) fn draw(pattern: &Pattern) -> String {
    let mut dxf = Dxf::default();
    dxf.pair(
        999,
        "flat pattern, one unit is a millimetre, numbers to 6 decimals",
    );
    dxf.section("HEADER", |dxf| {
        dxf.pair(9, "$ACADVER");
        dxf.pair(1, "AC1009");
        for (key, corner) in [("$EXTMIN", Vector::zero()), ("$EXTMAX", pattern.size)] {
            dxf.pair(9, key);
            dxf.place(10, corner);
        }
    });
    dxf.section("TABLES", |dxf| tables(dxf, pattern));
    dxf.section("ENTITIES", |dxf| {
        for (number, layer) in pattern.layers.iter().enumerate() {
            let label = format!("layer {}", number + 1);
            // `text` needs the middle of a text, but `layer.label` is its left end. The label of a layer is about 4
            // times as wide as high.
            let middle = layer.label + Vector::new([2.0 * LABEL, 0.0]);
            dxf.text(middle, LABEL, 0.0, &label);
            for part in &layer.parts {
                let on = name(number, part.is_actuator);
                dxf.outline(&on, part);
                for end in [part.axis.from, part.axis.to] {
                    dxf.circle(&on, end, pattern.sizes.hole);
                }
                let height = pattern.label_height();
                dxf.text(part.axis.middle(), height, part.angle, &part.label());
            }
        }
    });
    dxf.pair(0, "EOF");
    dxf.0
}

/// Writes two tables of the DXF file: the line types, which layers refer to, and the layers.
fn tables(dxf: &mut Dxf, pattern: &Pattern) {
    let lines = "0 TABLE 2 LTYPE 70 1 0 LTYPE 2 CONTINUOUS 70 0 3 Solid 72 65 73 0 40 0.0 0 ENDTAB";
    let words: Vec<&str> = lines.split(' ').collect();
    words
        .chunks(2)
        .for_each(|pair| dxf.0 += &format!("{}\r\n{}\r\n", pair[0], pair[1]));
    let of_layer = |layer| {
        [(false, SKELETON), (true, ACTUATOR)].map(|(kind, colour)| (name(layer, kind), colour))
    };
    let mut layers: Vec<_> = (0..pattern.layers.len()).flat_map(of_layer).collect();
    layers.push((LABELS.to_owned(), GREEN));
    dxf.pair(0, "TABLE");
    dxf.pair(2, "LAYER");
    dxf.pair(70, layers.len());
    for (name, colour) in layers {
        dxf.pair(0, "LAYER");
        dxf.pair(2, name);
        dxf.pair(70, 0);
        dxf.pair(62, colour);
        dxf.pair(6, "CONTINUOUS");
    }
    dxf.pair(0, "ENDTAB");
}
