//! Comparing answers with the reference answers, as their README states it.

use serde_json::{Map, Value};

/// How far an answer is from its reference.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswerCheck {
    /// The field that is furthest off.
    pub field: String,
    /// Its `max |a - b| / max |b|`; infinite where lengths or integers differ.
    pub error: f64,
    /// The error that the reference allows.
    pub tolerance: f64,
    /// How many fields were compared.
    pub fields: usize,
}

impl AnswerCheck {
    /// True if something was compared, and all of it is close enough.
    pub fn is_close(&self) -> bool {
        self.fields > 0 && self.error <= self.tolerance
    }
}

/// Fields of a reference that are not part of the answer.
const DESCRIPTION: [&str; 4] = ["case", "kind", "tolerance", "digest"];

/// Compares every field of a reference.
pub fn compare(answer: &Value, reference: &Value) -> AnswerCheck {
    let mut comparison = AnswerCheck {
        field: String::new(),
        error: 0.0,
        tolerance: reference["tolerance"].as_f64().unwrap_or(0.0),
        fields: 0,
    };
    let fields = reference.as_object().cloned().unwrap_or_default();
    for (name, expected) in &fields {
        if !DESCRIPTION.contains(&name.as_str()) {
            comparison.add(name, &answer[name], expected);
        }
    }
    if let Some(expected) = fields.get("digest") {
        comparison.add("digest", &digest(answer, expected), expected);
    }
    comparison
}

impl AnswerCheck {
    fn add(&mut self, name: &str, got: &Value, expected: &Value) {
        if let Value::Object(parts) = expected {
            for (part, expected) in parts {
                self.add(&format!("{name}.{part}"), &got[part], expected);
            }
            return;
        }
        self.fields += 1;
        let error = relative_error(got, expected);
        if error > self.error {
            self.error = error;
            self.field = name.to_owned();
        }
    }
}

/// `max |a - b| / max |b|`; infinite where the shapes differ, or integers do.
fn relative_error(got: &Value, expected: &Value) -> f64 {
    if got == expected {
        return 0.0;
    }
    let (mut a, mut b) = (Vec::new(), Vec::new());
    let integers = |numbers: &Vec<&Value>| numbers.iter().all(|n| n.is_u64());
    if !(numbers(got, &mut a) && numbers(expected, &mut b)) || a.len() != b.len() || integers(&b) {
        return f64::INFINITY;
    }
    let float = |n: &&Value| n.as_f64().unwrap_or(f64::NAN);
    let pairs = a.iter().map(float).zip(b.iter().map(float));
    let mut error = 0.0_f64;
    let mut size = 0.0_f64;
    for (a, b) in pairs {
        if !(a - b).is_finite() {
            return f64::INFINITY;
        }
        error = error.max((a - b).abs());
        size = size.max(b.abs());
    }
    if size == 0.0 { error } else { error / size }
}

/// Gathers the numbers of nested lists; false where there is anything else.
fn numbers<'a>(value: &'a Value, to: &mut Vec<&'a Value>) -> bool {
    match value {
        Value::Array(list) => list.iter().all(|item| numbers(item, to)),
        Value::Number(_) => {
            to.push(value);
            true
        }
        _ => false,
    }
}

/// A sparse answer as vectors, for its reductions.
struct Sparse {
    residuals: Vec<f64>,
    reprojections: usize,
    columns: usize,
    rows: Vec<usize>,
    cols: Vec<usize>,
    vals: Vec<f64>,
}

/// The fixed pattern of weights that the reductions use.
fn weight(i: usize) -> f64 {
    ((7919 * i + 13) % 10007) as f64 / 5003.5 - 1.0
}

fn list<T>(value: &Value, item: impl Fn(&Value) -> Option<T>) -> Vec<T> {
    let items = value.as_array().into_iter().flatten();
    items.filter_map(item).collect()
}

fn index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|index| usize::try_from(index).ok())
}

/// The reductions of a bundle adjustment's answer that stand in for its long arrays.
fn digest(answer: &Value, expected: &Value) -> Value {
    let jacobian = &answer["jacobian"];
    let mut residuals = list(&answer["reproj_err"], Value::as_f64);
    let reprojections = residuals.len();
    residuals.extend(list(&answer["w_err"], Value::as_f64));
    let sparse = Sparse {
        residuals,
        reprojections,
        columns: index(&jacobian["ncols"]).unwrap_or(0),
        rows: list(&jacobian["rows"], index),
        cols: list(&jacobian["cols"], index),
        vals: list(&jacobian["vals"], Value::as_f64),
    };
    if !sparse.fits() {
        return Value::Null;
    }
    let mut digest = sparse.reductions();
    let rows = expected["rows_of_jacobian"].as_object();
    let rows = rows.into_iter().flat_map(Map::keys);
    digest.insert(
        "rows_of_jacobian".into(),
        rows.map(|r| sparse.row(r)).collect(),
    );
    Value::Object(digest)
}

impl Sparse {
    /// True if the lengths of the parts fit together, so that they can be reduced.
    fn fits(&self) -> bool {
        let entries = self.vals.len();
        self.rows.len() == self.residuals.len() + 1
            && self.rows.is_sorted()
            && self.rows.last() == Some(&entries)
            && self.cols.len() == entries
            && self.cols.iter().all(|&column| column < self.columns)
            && self.reprojections >= 4
            && self.residuals.len() > self.reprojections
            && self.columns >= 11
    }

    fn row(&self, name: &str) -> (String, Value) {
        let row = name.parse::<usize>().unwrap_or(usize::MAX);
        let offset = |row: Option<usize>| row.and_then(|row| self.rows.get(row));
        let ends = (offset(Some(row)), offset(row.checked_add(1)));
        let (Some(&start), Some(&end)) = ends else {
            return (name.to_owned(), Value::Null);
        };
        let (cols, vals) = (&self.cols[start..end], &self.vals[start..end]);
        (
            name.to_owned(),
            serde_json::json!({ "cols": cols, "vals": vals }),
        )
    }

    fn reductions(&self) -> Map<String, Value> {
        let (reprojection, weights) = self.residuals.split_at(self.reprojections);
        let mut gradient = vec![0.0; self.columns];
        let mut jv_weighted = 0.0;
        for (row, &residual) in self.residuals.iter().enumerate() {
            let mut product = 0.0;
            for k in self.rows[row]..self.rows[row + 1] {
                gradient[self.cols[k]] += self.vals[k] * residual;
                product += self.vals[k] * weight(self.cols[k]);
            }
            jv_weighted += weight(row) * product;
        }
        let weighted = |numbers: &[f64]| -> f64 {
            let numbers = numbers.iter().enumerate();
            numbers.map(|(i, x)| weight(i) * x).sum()
        };
        let absolute = |numbers: &[f64]| numbers.iter().map(|x| x.abs()).sum::<f64>();
        let square = |numbers: &[f64]| numbers.iter().map(|x| x * x).sum::<f64>();
        let reductions = serde_json::json!({
            "half_square": 0.5 * square(&self.residuals),
            "reproj_weighted": weighted(reprojection),
            "reproj_first": reprojection[..4],
            "reproj_last": reprojection[self.reprojections - 2..],
            "w_first": weights[0],
            "w_last": weights[weights.len() - 1],
            "vals_abs": absolute(&self.vals),
            "vals_square": square(&self.vals),
            "jv_weighted": jv_weighted,
            "jtf_abs": absolute(&gradient),
            "jtf_weighted": weighted(&gradient),
            "jtf_first_camera": gradient[..11],
            "pattern": {
                "nrows": self.residuals.len(),
                "ncols": self.columns,
                "nnz": self.vals.len(),
                "cols_hash": hash(&self.cols),
                "rows_hash": hash(&self.rows),
            },
        });
        match reductions {
            Value::Object(fields) => fields,
            _ => Map::new(),
        }
    }
}

/// `sum_k (n[k] + 1)((k mod 1009) + 1) mod 2^61`.
fn hash(numbers: &[usize]) -> u64 {
    let numbers = numbers.iter().enumerate();
    let terms = numbers.map(|(k, &n)| (n as u64 + 1) * ((k % 1009) as u64 + 1));
    terms.fold(0, |sum, term| (sum + term) % (1 << 61))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_worst_field_is_found() {
        let reference = json!({"case": "x", "tolerance": 1e-3, "a": [1.0, -4.0], "b": {"c": 2.0}});
        let close = compare(&json!({"a": [1.0, -4.001], "b": {"c": 2.0}}), &reference);
        assert!(close.is_close() && close.field == "a" && close.fields == 2);
        // 0.001 of 4.
        assert!((close.error - 2.5e-4).abs() < 1e-12, "{close:?}");
        let wrong = [
            json!({"a": [1.0, -4.1], "b": {"c": 2.0}}),
            json!({"a": [1.0], "b": {"c": 2.0}}),
            json!({"a": [1.0, -4.0]}),
            json!({"a": [1.0, null], "b": {"c": 2.0}}),
        ];
        for answer in &wrong {
            assert!(!compare(answer, &reference).is_close(), "{answer}");
        }
        assert!(!compare(&json!({}), &json!({"tolerance": 1.0})).is_close());
    }

    #[test]
    fn integers_must_agree_exactly() {
        let reference = json!({"tolerance": 1.0, "cols": [0, 1, 2]});
        assert!(compare(&json!({"cols": [0, 1, 2]}), &reference).is_close());
        assert!(!compare(&json!({"cols": [0, 1, 3]}), &reference).is_close());
    }
}
