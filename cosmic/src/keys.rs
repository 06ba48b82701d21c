//! The keys of files and the columns of tables. Each is declared once: the struct, the file, the table and the
//! documentation follow from this declaration.

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
    /// The names of the table columns that show the key.
    pub columns: Vec<&'static str>,
    /// The keys inside the value, if the value is an object or a list of objects. Empty for any other value.
    pub parts: Vec<Key>,
}

/// A struct whose fields are the keys of a JSON object in a file.
pub trait Keyed {
    /// Every key, in the order in which the file lists them.
    fn keys() -> Vec<Key>;

    /// The values of all columns that show this struct, in the order of [`columns`].
    fn cells(&self) -> Vec<Cell>;
}

/// The names of all table columns that show `keys`, in the order of the keys.
pub fn columns(keys: &[Key]) -> Vec<&'static str> {
    keys.iter().flat_map(|key| key.columns.clone()).collect()
}

/// The content of a cell in a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// Text that is a fixed word.
    Word(&'static str),
    /// A whole number.
    Count(usize),
    /// A number.
    Number(f64),
    /// No value: the cell is empty.
    Missing,
}

impl Cell {
    /// The number in the cell; `None` for a missing value or a word.
    pub fn number(self) -> Option<f64> {
        match self {
            Self::Count(count) => Some(count as f64),
            Self::Number(number) => Some(number),
            Self::Word(_) | Self::Missing => None,
        }
    }

    /// The cell as CSV. A number has the shortest decimals that read back to the same bits. A missing value is an empty
    /// cell.
    pub fn csv(self) -> String {
        match self {
            Self::Word(word) => word.to_owned(),
            Self::Count(count) => count.to_string(),
            Self::Number(number) => format!("{number:?}"),
            Self::Missing => String::new(),
        }
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count)
    }
}

impl From<&'static str> for Cell {
    fn from(word: &'static str) -> Self {
        Self::Word(word)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, T::into)
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
///         volume as "V": f64, "number", unit "m", columns ["V"];
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
macro_rules! keys {
    (
        $(#[$about:meta])+
        struct $File:ident {
            $(
                $(#[doc = $doc:literal])+
                $(#[serde($($serde:tt)*)])?
                $field:ident $(as $name:literal)?: $Type:ty, $kind:literal $(, unit $unit:literal)?
                $(, parts $Part:ty $(as $flat:ident)?)?
                $(, columns [$($column:literal),+] $(of $of:expr)?)?;
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
                        $(vec![$($column),+],)?
                        $($($crate::keys::$flat(&<$Part as $crate::keys::Keyed>::keys()),)?)?
                        Vec::new(),
                    ].concat(),
                    parts: [$(<$Part as $crate::keys::Keyed>::keys(),)? Vec::new()].concat(),
                },)+]
            }

            fn cells(&self) -> Vec<$crate::keys::Cell> {
                let cells: Vec<Vec<$crate::keys::Cell>> = vec![$(
                    $(keys!(@cells self, $field, [$($column),+] $(of $of)?),)?
                    $($(keys!(@parts self, $field, $Part, $flat),)?)?
                )+];
                cells.concat()
            }
        }
    };
    (@cells $self:ident, $field:ident, [$column:literal]) => {
        vec![$crate::keys::Cell::from($self.$field)]
    };
    (@cells $self:ident, $field:ident, [$column:literal] of $of:expr) => {{
        let of: fn(&Self) -> _ = $of;
        vec![$crate::keys::Cell::from(of($self))]
    }};
    (@cells $self:ident, $field:ident, $columns:tt) => {
        $self.$field.into_iter().map($crate::keys::Cell::from).collect()
    };
    (@cells $self:ident, $field:ident, $columns:tt of $of:expr) => {{
        let of: fn(&Self) -> _ = $of;
        of($self).into_iter().map($crate::keys::Cell::from).collect()
    }};
    (@parts $self:ident, $field:ident, $Part:ty, $flat:ident) => {
        match &$self.$field {
            Some(part) => $crate::keys::Keyed::cells(part),
            None => {
                let keys = <$Part as $crate::keys::Keyed>::keys();
                $crate::keys::$flat(&keys).iter().map(|_| $crate::keys::Cell::Missing).collect()
            }
        }
    };
}
pub(crate) use keys;
