//! The keys of files and the columns of tables. Each is declared once: the struct, the file, the table and the
//! documentation follow from this declaration.

use crate::numbers::fixed;

/// A key of a JSON file.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// The name in files.
    pub name: &'static str,
    /// The type of the value in words, such as "number or `null`".
    pub kind: &'static str,
    /// The unit of the value; empty if there is none.
    pub unit: &'static str,
    /// The meaning of the key, in Markdown on one line.
    pub doc: &'static str,
    /// The table columns that show the key, or its parts.
    pub columns: Vec<KeyColumn>,
    /// The keys inside the value, if the value is an object or a list of objects. Empty for any other value.
    pub parts: Vec<Key>,
}

/// A column of tables that shows a key, or a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyColumn {
    /// The heading.
    pub name: &'static str,
    /// The unit of the numbers; empty if there is none.
    pub unit: &'static str,
    /// The meaning in Markdown: the first sentence about the key.
    pub says: &'static str,
    /// The number of decimals in texts for people.
    pub decimals: usize,
}

impl Key {
    /// This key with columns of these names, which have the given decimals, or otherwise none for whole numbers and three
    /// for others.
    pub fn with_columns(mut self, names: &[&'static str], decimals: &[usize]) -> Self {
        let says = self
            .doc
            .split_once(". ")
            .map_or(self.doc, |(first, _)| first);
        let usual = if self.kind.starts_with("whole") { 0 } else { 3 };
        let column = |name: &&'static str| KeyColumn {
            name,
            unit: self.unit,
            says: says.trim_end_matches('.'),
            decimals: decimals.first().copied().unwrap_or(usual),
        };
        self.columns.extend(names.iter().map(column));
        self
    }
}

/// A struct whose fields are the keys of a JSON object in a file.
pub trait Keyed {
    /// Every key, in the order in which the file lists them.
    fn keys() -> Vec<Key>;

    /// The numbers of all [`columns`] that show this struct. A number is `None` if the file does not have it.
    fn numbers(&self) -> Vec<Option<f64>>;

    /// The number in a column as text, with its decimals and its unit; `None` if the file does not have it.
    ///
    /// # Panics
    /// If no column has this name.
    fn shown(&self, column: &str) -> Option<String> {
        let (at, KeyColumn { unit, decimals, .. }) = placed(&Self::keys(), column);
        let text = fixed(self.numbers()[at]?, decimals);
        Some(format!("{text} {unit}").trim_end().to_owned())
    }
}

impl<K: Keyed> Keyed for &K {
    fn keys() -> Vec<Key> {
        K::keys()
    }

    fn numbers(&self) -> Vec<Option<f64>> {
        K::numbers(self)
    }
}

/// All table columns that show `keys`, in the order of the keys.
pub fn columns(keys: &[Key]) -> Vec<KeyColumn> {
    keys.iter().flat_map(|key| key.columns.clone()).collect()
}

/// The column of `K` that is named `name`.
///
/// # Panics
/// If no column has this name.
pub fn column<K: Keyed>(name: &str) -> KeyColumn {
    placed(&K::keys(), name).1
}

/// A column and its place among all columns of `keys`.
fn placed(keys: &[Key], name: &str) -> (usize, KeyColumn) {
    let mut all = columns(keys).into_iter().enumerate();
    let found = all.find(|(_, column)| column.name == name);
    found.unwrap_or_else(|| panic!("no column is named {name}"))
}

/// The value of a key that is a column.
pub trait ColumnValue {
    /// The number in the column; `None` for a missing value.
    fn number(self) -> Option<f64>;
}

impl ColumnValue for f64 {
    fn number(self) -> Option<f64> {
        Some(self)
    }
}

impl ColumnValue for usize {
    fn number(self) -> Option<f64> {
        Some(self as f64)
    }
}

impl<T: ColumnValue> ColumnValue for Option<T> {
    fn number(self) -> Option<f64> {
        self.and_then(T::number)
    }
}

/// Declares a struct whose fields are the keys of a file.
///
/// ```text
/// keys! {
///     /// What the file holds.
///     #[derive(Serialize, Deserialize)]
///     struct Summary {
///         /// What the key means.
///         volume as "V": f64, "number", unit "m", columns ["V"] decimals 4;
///         /// An object, whose columns are those of its type.
///         structure: Option<Structure>, "object or `null`", parts Structure as columns;
///         /// Objects that have no columns.
///         starts: Vec<Start>, "list of objects", parts Start;
///     }
/// }
/// ```
///
/// A single column shows the value of the field. Several columns show its entries. `columns ["a"] of
/// |file: &Summary| ...` shows another value, computed from the whole struct.
#[macro_export]
macro_rules! keys {
    (
        $(#[$about:meta])+
        struct $File:ident {
            $(
                $(#[doc = $doc:literal])+
                $(#[serde($($serde:tt)*)])?
                $field:ident $(as $name:literal)?: $Type:ty, $kind:literal $(, unit $unit:literal)?
                $(, parts $Part:ty $(as $flat:ident)?)?
                $(, columns [$($column:literal),+] $(decimals $decimals:literal)? $(of $of:expr)?)?;
            )+
        }
    ) => {
        $(#[$about])+
        pub struct $File {
            $(
                $(#[doc = $doc])+
                $(#[doc = concat!("\n\nUnit: ", $unit, ".")])?
                $(#[serde(rename = $name)])?
                $(#[serde($($serde)*)])?
                pub $field: $Type,
            )+
        }

        impl $crate::keys::Keyed for $File {
            fn keys() -> Vec<$crate::keys::Key> {
                vec![$($crate::keys::Key {
                    name: [$($name,)? stringify!($field)][0],
                    kind: $kind,
                    unit: concat!($($unit)?),
                    doc: concat!($($doc),+).trim_ascii(),
                    columns: [
                        $($($crate::keys::$flat(&<$Part as $crate::keys::Keyed>::keys()),)?)?
                        Vec::new(),
                    ].concat(),
                    parts: [$(<$Part as $crate::keys::Keyed>::keys(),)? Vec::new()].concat(),
                }$(.with_columns(&[$($column),+], &[$($decimals)?]))?,)+]
            }

            fn numbers(&self) -> Vec<Option<f64>> {
                let numbers: Vec<Vec<Option<f64>>> = vec![$(
                    $($crate::keys!(@numbers self, $field, [$($column),+] $(of $of)?),)?
                    $($($crate::keys!(@parts self, $field, $Part, $flat),)?)?
                )+];
                numbers.concat()
            }
        }
    };
    (@numbers $self:ident, $field:ident, [$column:literal]) => {
        vec![$crate::keys::ColumnValue::number($self.$field)]
    };
    (@numbers $self:ident, $field:ident, [$column:literal] of $of:expr) => {{
        let of: fn(&Self) -> _ = $of;
        vec![$crate::keys::ColumnValue::number(of($self))]
    }};
    (@numbers $self:ident, $field:ident, $columns:tt) => {
        $self.$field.into_iter().map($crate::keys::ColumnValue::number).collect()
    };
    (@numbers $self:ident, $field:ident, $columns:tt of $of:expr) => {{
        let of: fn(&Self) -> _ = $of;
        of($self).into_iter().map($crate::keys::ColumnValue::number).collect()
    }};
    (@parts $self:ident, $field:ident, $Part:ty, $flat:ident) => {
        match &$self.$field {
            Some(part) => $crate::keys::Keyed::numbers(part),
            None => {
                let keys = <$Part as $crate::keys::Keyed>::keys();
                vec![None; $crate::keys::$flat(&keys).len()]
            }
        }
    };
}
