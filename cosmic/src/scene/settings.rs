//! The declaration of a scene's settings: one place says everything of a key.

/// Declares a section of the scene, or the names that a setting is chosen from.
///
/// ```text
/// settings! {
///     /// What the section is about.
///     struct LatticeSettings {
///         /// What the key means.
///         spacing: f64 = 0.1, allowed within(1e-3, 100.0), unit "m", source "D1";
///     }
/// }
/// ```
///
/// The type and the default are Rust; `allowed` is for numbers, and `unit` for those that have one.
/// From this follow the struct with public fields, its `Default`, its documentation, and
/// [`Settings`](super::field::Settings), by which the reader, the template and the documentation of
/// the keys are made. An `enum` lists its members with their names in files.
macro_rules! settings {
    (
        $(#[doc = $about:literal])+
        struct $Settings:ident {
            $(
                $(#[doc = $doc:literal])+
                $key:ident: $type:ty = $default:expr
                $(, allowed $limits:expr)? $(, unit $unit:literal)?, source $source:literal;
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, PartialEq, serde::Serialize)]
        pub struct $Settings {
            $(
                $(#[doc = $doc])+
                #[doc = concat!(
                    "\n\nDefault: `", stringify!($default), "`", $(" ", $unit,)? " (", $source, ")."
                )]
                pub $key: $type,
            )+
        }

        impl Default for $Settings {
            fn default() -> Self {
                Self { $($key: $default,)+ }
            }
        }

        impl super::field::Settings for $Settings {
            fn about(&self) -> &'static str {
                concat!($($about),+).trim_ascii()
            }

            fn fields(&mut self) -> Vec<super::field::Field<'_>> {
                vec![$(super::field::Field {
                    key: stringify!($key),
                    doc: concat!($($doc),+).trim_ascii(),
                    unit: concat!("", $($unit)?),
                    source: $source,
                    limits: [$($limits,)? super::limits::Limits::NONE][0],
                    value: &mut self.$key,
                },)+]
            }
        }
    };
    (
        $(#[$about:meta])+
        enum $Choice:ident {
            $($(#[$doc:meta])+ $Member:ident = $name:literal,)+
        }
    ) => {
        $(#[$about])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $Choice {
            $($(#[$doc])+ #[serde(rename = $name)] $Member,)+
        }

        impl super::value::Named for $Choice {
            const ALL: &'static [(&'static str, Self)] = &[$(($name, Self::$Member),)+];
        }
    };
}

pub(super) use settings;
