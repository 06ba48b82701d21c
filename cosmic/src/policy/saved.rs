//! How files store the parameters of a controller: block by block, with a matrix as a list of rows.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::block::{B1, Block, Controller, NETWORK, Part, Shape};
use super::mlp::{Layer, Network};
use super::tempo::TEMPO;
use crate::error::{self, Error, fits, some};
use crate::scene::ControllerSettings;

/// The block of the network that has one number for each hidden unit: its biases.
const HIDDEN: &str = B1;

/// The parameters of a controller as files store them: block by block, with a matrix as a list of rows.
/// Gradients with respect to the parameters have this form too.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights(Vec<(Cow<'static, str>, Numbers)>);

/// The numbers of a block.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
enum Numbers {
    Vector(Vec<f64>),
    Rows(Vec<Vec<f64>>),
}

impl Numbers {
    /// Splits the flat numbers of a matrix into rows.
    fn rows(numbers: &[f64], columns: usize) -> Self {
        let rows = numbers.chunks_exact(columns.max(1));
        Self::Rows(rows.map(<[f64]>::to_vec).collect())
    }
}

impl Weights {
    /// Makes a controller with the saved parameters. `blocks` are the blocks that the policy declares.
    ///
    /// # Errors
    /// If a block is missing, is unknown or has the wrong shape. The message names `file`.
    pub fn controller(&self, blocks: &[Block], file: &str) -> error::Result<Controller<f64>> {
        let says = |says: String| Err(Error::Usage(format!("{file}: {says}")));
        let is_known = |name: &str| blocks.iter().any(|block| block.name == name);
        if let Some((name, _)) = self.0.iter().find(|(name, _)| !is_known(name)) {
            let names: Vec<_> = blocks.iter().map(|b| format!("`{}`", b.name)).collect();
            let expected = names.join(", ");
            let hint = match *name == TEMPO {
                true => {
                    "; the robot has a learned clock: set `controller.clock` of the scene to \"learned\""
                }
                false => "",
            };
            return says(format!(
                "unknown block `controller.{name}`; expected {expected}{hint}"
            ));
        }
        let mut numbers = Vec::new();
        for Block { name, shape, .. } in blocks {
            let fits = |what: &str, found, expected| fits(file, what, found, expected);
            let found = self.0.iter().find(|(other, _)| other == name);
            let entries = format!("entries in `controller.{name}`");
            match (found.map(|(_, numbers)| numbers), *shape) {
                (None, _) if *name == TEMPO => {
                    return says(format!(
                        "`controller.{name}` is missing: the robot has a fixed clock; set `controller.clock` of the \
                         scene to \"fixed\", or add `\"{name}\": [0.0]` to the file's `controller`"
                    ));
                }
                (None, _) => return says(format!("`controller.{name}` is missing")),
                (Some(Numbers::Vector(vector)), Shape::Vector(len)) => {
                    fits(&entries, vector.len(), len)?;
                    numbers.extend(vector);
                }
                (Some(Numbers::Rows(matrix)), Shape::Matrix { rows, columns }) => {
                    fits(&format!("rows of `controller.{name}`"), matrix.len(), rows)?;
                    for (i, row) in matrix.iter().enumerate() {
                        let what = format!("entries in `controller.{name}[{i}]`");
                        fits(&what, row.len(), columns)?;
                        numbers.extend(row);
                    }
                }
                (Some(_), Shape::Vector(_)) => {
                    return says(format!("`controller.{name}` must be a list of numbers"));
                }
                (Some(_), Shape::Matrix { .. }) => {
                    return says(format!("`controller.{name}` must be a list of rows"));
                }
            }
        }
        Ok(Controller::new(blocks, numbers))
    }

    /// Sorts the rows of a block that has one row or number for each edge: row `k` becomes the former row `order[k]`.
    /// `fewer` is the same block for a lattice with one edge less. Returns false, and changes nothing, if the block does
    /// not have one row or number for each edge.
    pub(crate) fn sort(&mut self, block: &Block, fewer: &Block, order: &[usize]) -> bool {
        let of_edges = match (block.shape, fewer.shape) {
            (Shape::Vector(len), Shape::Vector(less)) => {
                (len, less) == (order.len(), order.len() - 1)
            }
            (
                Shape::Matrix { rows, columns },
                Shape::Matrix {
                    rows: less,
                    columns: same,
                },
            ) => (rows, less, columns) == (order.len(), order.len() - 1, same),
            _ => false,
        };
        let own = self.0.iter_mut().find(|(name, _)| *name == block.name);
        match own.map(|(_, numbers)| numbers) {
            Some(Numbers::Vector(numbers)) if of_edges && numbers.len() == order.len() => {
                *numbers = order.iter().map(|&edge| numbers[edge]).collect();
            }
            Some(Numbers::Rows(rows)) if of_edges && rows.len() == order.len() => {
                *rows = order.iter().map(|&edge| rows[edge].clone()).collect();
            }
            // Another check refuses a block that is missing or has the wrong shape.
            _ => return of_edges,
        }
        true
    }

    /// The number of hidden units; `None` if the parameters do not belong to a network.
    fn hidden(&self) -> Option<usize> {
        let found = self.0.iter().find(|(name, _)| *name == HIDDEN);
        found.map(|(_, numbers)| match numbers {
            Numbers::Vector(vector) => vector.len(),
            Numbers::Rows(rows) => rows.len(),
        })
    }

    /// If the parameters belong to a network, copies its number of hidden units to `settings`.
    ///
    /// # Errors
    /// If the network has no hidden units.
    pub(crate) fn set_hidden(
        &self,
        settings: &mut ControllerSettings,
        file: &str,
    ) -> error::Result<()> {
        if let Some(hidden) = self.hidden() {
            some(file, &format!("entries in `controller.{HIDDEN}`"), hidden)?;
            settings.hidden = hidden;
        }
        Ok(())
    }

    /// If the parameters belong to a network, checks that it has as many hidden units as `settings` state. Parameters
    /// of any other policy pass.
    ///
    /// # Errors
    /// [`Error::Misfit`].
    pub(crate) fn check_hidden(
        &self,
        settings: &ControllerSettings,
        file: &str,
    ) -> error::Result<()> {
        let what = format!("entries in `controller.{HIDDEN}`");
        let hidden = self.hidden();
        hidden.map_or(Ok(()), |hidden| fits(file, &what, hidden, settings.hidden))
    }

    /// For every block, its name, the lengths of its axes, and its numbers.
    pub fn blocks(&self) -> impl Iterator<Item = (&str, Vec<usize>, Vec<f64>)> {
        self.0.iter().map(|(name, numbers)| match numbers {
            Numbers::Vector(vector) => (&**name, vec![vector.len()], vector.clone()),
            Numbers::Rows(rows) => {
                let columns = rows.first().map_or(0, Vec::len);
                (&**name, vec![rows.len(), columns], rows.concat())
            }
        })
    }
}

impl From<&Controller<f64>> for Weights {
    fn from(controller: &Controller<f64>) -> Self {
        let block = |(name, shape, range): (&str, Shape, Range<usize>)| {
            let numbers = &controller.numbers()[range];
            let numbers = match shape {
                Shape::Vector(_) => Numbers::Vector(numbers.to_vec()),
                Shape::Matrix { columns, .. } => Numbers::rows(numbers, columns),
            };
            (Cow::Owned(name.to_owned()), numbers)
        };
        Self(controller.blocks().map(block).collect())
    }
}

impl From<&Network<f64>> for Weights {
    fn from(network: &Network<f64>) -> Self {
        let layers = [&network.first, &network.second].into_iter();
        let numbers = layers.flat_map(|Layer { weights, biases }| {
            let rows = Numbers::rows(weights, weights.len() / biases.len().max(1));
            [rows, Numbers::Vector(biases.clone())]
        });
        let names = NETWORK.into_iter().map(Cow::Borrowed);
        Self(names.zip(numbers).collect())
    }
}

impl Serialize for Weights {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, numbers)| (name, numbers)))
    }
}

impl<'de> Deserialize<'de> for Weights {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Blocks)
    }
}

/// Deserializes the blocks of a controller.
struct Blocks;

impl<'de> Visitor<'de> for Blocks {
    type Value = Weights;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("the blocks of a controller")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Weights, A::Error> {
        let mut blocks: Vec<(Cow<'static, str>, Numbers)> = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            if blocks.iter().any(|(other, _)| *other == *name) {
                return Err(A::Error::custom(format!("duplicate field `{name}`")));
            }
            blocks.push((Cow::Owned(name), map.next_value()?));
        }
        Ok(Weights(blocks))
    }
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Entries)
    }
}

/// Deserializes the entries of a block: numbers, or rows of numbers.
struct Entries;

impl<'de> Visitor<'de> for Entries {
    type Value = Numbers;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a sequence")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Numbers, A::Error> {
        let (mut vector, mut rows) = (Vec::new(), Vec::new());
        match entries.next_element()? {
            None => Ok(Numbers::Vector(vector)),
            Some(Entry::Number(number)) => {
                vector.push(number);
                while let Some(number) = entries.next_element()? {
                    vector.push(number);
                }
                Ok(Numbers::Vector(vector))
            }
            Some(Entry::Row(row)) => {
                rows.push(row);
                while let Some(row) = entries.next_element()? {
                    rows.push(row);
                }
                Ok(Numbers::Rows(rows))
            }
        }
    }
}

/// The first entry of a block in a file. It shows whether the block is a vector or a matrix.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a number or a row of numbers")]
enum Entry {
    Number(f64),
    Row(Vec<f64>),
}

impl Serialize for Controller<f64> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Weights::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Controller<f64> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (mut parts, mut all) = (Vec::new(), Vec::new());
        for (name, numbers) in Weights::deserialize(deserializer)?.0 {
            let (shape, numbers) = match numbers {
                Numbers::Vector(vector) => (Shape::Vector(vector.len()), vector),
                Numbers::Rows(matrix) => {
                    let (rows, columns) = (matrix.len(), matrix[0].len());
                    if matrix.iter().any(|row| row.len() != columns) {
                        return Err(D::Error::custom(format!(
                            "the rows of `{name}` differ in length"
                        )));
                    }
                    (Shape::Matrix { rows, columns }, matrix.concat())
                }
            };
            parts.push(Part { name, shape });
            all.extend(numbers);
        }
        Ok(Controller::of_parts(parts.into(), all))
    }
}
