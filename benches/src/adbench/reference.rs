//! Compares answers with the reference answers of ADBench cases.

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use crate::distance::largest_distance;

/// The largest difference between an answer and its reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// The field with the largest error, as a JSON pointer.
    pub field: String,
    /// The error of that field, `max |a - b| / max |b|`, where `b` is the reference. It is infinite if the lengths of
    /// lists or integers differ.
    pub error: f64,
    /// The error that the reference allows.
    pub tolerance: f64,
}

impl Gap {
    /// True if all fields are close enough.
    pub fn is_close(&self) -> bool {
        self.error <= self.tolerance
    }
}

/// The fields of a reference file that describe the case and are not part of the answer.
const DESCRIPTION: [&str; 3] = ["/case", "/kind", "/tolerance"];

/// Compares every field of a reference with the answer. A reference may contain a `digest` instead of long lists.
pub fn gap(answer: &Value, reference: &Value) -> Gap {
    let expected = reference.get("digest");
    let digest = expected.map(|expected| json!({ "digest": digest(answer, expected) }));
    let answer = digest.as_ref().unwrap_or(answer);
    let mut leaves = Vec::new();
    collect(String::new(), reference, &mut leaves);
    leaves.retain(|(field, _)| !DESCRIPTION.contains(&field.as_str()));
    let errors = leaves.into_iter().map(|(field, expected)| {
        let error = answer
            .pointer(&field)
            .map_or(f64::INFINITY, |got| error(got, expected));
        (field, error)
    });
    let worst = errors.max_by(|a, b| a.1.total_cmp(&b.1));
    let (field, error) = worst.unwrap_or((String::new(), f64::INFINITY));
    Gap {
        field,
        error,
        tolerance: reference["tolerance"].as_f64().unwrap_or(0.0),
    }
}

/// Collects every value that is not an object, with its JSON pointer. Objects are searched at any depth.
fn collect<'a>(pointer: String, value: &'a Value, leaves: &mut Vec<(String, &'a Value)>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                collect(format!("{pointer}/{name}"), value, leaves);
            }
        }
        _ => leaves.push((pointer, value)),
    }
}

fn error(got: &Value, expected: &Value) -> f64 {
    let integers = match expected {
        Value::Array(list) => list.iter().all(Value::is_u64),
        value => value.is_u64(),
    };
    if got == expected {
        0.0
    } else if integers {
        f64::INFINITY
    } else {
        largest_distance(got, expected)
    }
}

/// Replaces the long lists in the answer of a bundle adjustment by a digest, which is a few sums and a hash. Returns
/// `None` for other answers.
fn digest(answer: &Value, expected: &Value) -> Option<Value> {
    fn list<T: DeserializeOwned>(value: &Value) -> Option<Vec<T>> {
        Vec::deserialize(value).ok()
    }
    let jacobian = &answer["jacobian"];
    let ncols = jacobian["ncols"].as_u64()? as usize;
    let (rows, cols) = (
        list::<usize>(&jacobian["rows"])?,
        list::<usize>(&jacobian["cols"])?,
    );
    let (vals, reproj_err) = (
        list::<f64>(&jacobian["vals"])?,
        list::<f64>(&answer["reproj_err"])?,
    );
    let w_err = list::<f64>(&answer["w_err"])?;
    let residuals = [&reproj_err[..], &w_err].concat();
    let mut gradient = vec![0.0; ncols];
    let mut products = vec![0.0; residuals.len()];
    for (row, residual) in residuals.iter().enumerate() {
        for entry in *rows.get(row)?..*rows.get(row + 1)? {
            let (column, value) = (*cols.get(entry)?, *vals.get(entry)?);
            *gradient.get_mut(column)? += value * residual;
            products[row] += value * weight(column);
        }
    }
    let absolute = |numbers: &[f64]| numbers.iter().map(|x| x.abs()).sum::<f64>();
    let square = |numbers: &[f64]| numbers.iter().map(|x| x * x).sum::<f64>();
    let complete = |row: &String| {
        let row: usize = row.parse().ok()?;
        let entries = *rows.get(row)?..*rows.get(row + 1)?;
        let (cols, vals) = (cols.get(entries.clone())?, vals.get(entries)?);
        Some(json!({ "cols": cols, "vals": vals }))
    };
    let names = expected["rows_of_jacobian"].as_object()?.keys();
    let complete: Map<String, Value> = names
        .map(|row| (row.clone(), json!(complete(row))))
        .collect();
    Some(json!({
        "half_square": 0.5 * square(&residuals),
        "reproj_weighted": weighted(&reproj_err),
        "reproj_first": reproj_err.get(..4),
        "reproj_last": reproj_err.last_chunk::<2>(),
        "w_first": w_err.first(),
        "w_last": w_err.last(),
        "vals_abs": absolute(&vals),
        "vals_square": square(&vals),
        "jv_weighted": weighted(&products),
        "jtf_abs": absolute(&gradient),
        "jtf_weighted": weighted(&gradient),
        "jtf_first_camera": gradient.get(..11),
        "rows_of_jacobian": complete,
        "pattern": {
            "nrows": residuals.len(),
            "ncols": ncols,
            "nnz": vals.len(),
            "cols_hash": hash(&cols),
            "rows_hash": hash(&rows),
        },
    }))
}

/// Returns the weight of entry `i` in the sums of a digest.
fn weight(i: usize) -> f64 {
    ((7919 * i + 13) % 10007) as f64 / 5003.5 - 1.0
}

fn weighted(numbers: &[f64]) -> f64 {
    let numbers = numbers.iter().enumerate();
    numbers.map(|(i, x)| weight(i) * x).sum()
}

/// Returns `sum_k (n[k] + 1)((k mod 1009) + 1) mod 2^61`.
fn hash(numbers: &[usize]) -> u64 {
    let numbers = numbers.iter().enumerate();
    let terms = numbers.map(|(k, &n)| (n as u64 + 1) * ((k % 1009) as u64 + 1));
    terms.fold(0, |sum, term| (sum + term) % (1 << 61))
}
