//! The macro that declares the settings of a scene. Everything about a key is declared in one place.

/// Declares a section of a scene (`struct`), the names among which a setting chooses (`enum`), or the scene itself
/// (`scene`).
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
/// `struct Mud<R> {` declares the settings of a law. Its numbers have the type `R` instead of `f64`: the generic
/// methods of the law receive them in their own number type, so that a rollout can be differentiated with respect to
/// them. See [`StepInputs`].
///
/// [`StepInputs`]: crate::settings::StepInputs
///
/// `struct PhysicsSettings with ground: GroundSettings {` has one more field, whose settings are a separate section.
///
/// After the keys, `} of cases { ... }` declares numbers that scene files do not have: they are constants of every
/// scene, but a case has them as keys of the section and may have other values.
///
/// `} of physics { friction: R = "physics.friction"; }` declares numbers of the section `[physics]` that a law reads too. The law
/// has them as fields, and scenes fill them.
///
/// If the value of a key can follow from the robot and its world, `auto` states the formula before `source`: `auto "20
/// divided by the time scale"`. A file may then say `"auto"` instead of a number. `scene/derived/follow.rs` has the formulas.
///
/// If only some scenes read a key, a condition stands before `source`: `read "with the task reach" if |s: &Scene| ...`. A
/// scene that sets the key but does not read it gets a warning.
///
/// The type and the default are Rust code. `allowed` is for numbers, and `unit` for numbers with a unit. The macro
/// makes the struct with public fields, its `Default`, its documentation, and its `Settings`, from which the reader,
/// the template and the documentation of the keys are made. An `enum` lists its members with their names in files. The
/// `scene` lists its sections and the type of its base.
#[macro_export]
macro_rules! settings {
    ($(#[doc = $about:literal])+ struct $Settings:ident<$R:ident> $body:tt $(of physics $shared:tt)?) => {
        $crate::settings! { @struct [$R] $(#[doc = $about])+ struct $Settings $body $(of physics $shared)? }
    };
    (
        $(#[doc = $about:literal])+ struct $Settings:ident $(with $part:ident: $Part:ty)? { $($body:tt)* }
        $(of cases { $($constants:tt)* })?
    ) => {
        $crate::settings! {
            @struct [] $(#[doc = $about])+ struct $Settings $(with $part: $Part)? { $($body)* }
            $(of cases { $($constants)* })?
        }
    };
    (
        @struct [$($R:ident)?] $(#[doc = $about:literal])+
        struct $Settings:ident $(with $part:ident: $Part:ty)? {
            $(
                $(#[doc = $doc:literal])+
                $key:ident: $type:ty = $default:expr
                $(, allowed $limits:expr)? $(, unit $unit:literal)? $(, auto $auto:literal)?
                $(, read $when:literal if $is_read:expr)?, source $source:literal;
            )*
        }
        $(of cases {
            $($(#[doc = $says:literal])+ $constant:ident: $Of:ty = $always:expr, source $origin:literal;)*
        })?
        $(of physics {
            $($(#[doc = $meaning:literal])+ $shared:ident: $Number:ty = $path:literal;)*
        })?
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, PartialEq)]
        pub struct $Settings $(<$R = f64>)? {
            $(
                $(#[doc = $doc])+
                #[doc = concat!(
                    "\n\nDefault: `", stringify!($default), "`", $(" ", $unit,)? " (", $source, ")."
                )]
                pub $key: $type,
            )*
            $(
                #[doc = concat!("The section `[", stringify!($part), "]` of a file.")]
                pub $part: $Part,
            )?
            $($(
                $(#[doc = $says])+
                #[doc = concat!(
                    "\n\nAlways `", stringify!($always), "` in scenes (", $origin, "). A case may have another value."
                )]
                pub $constant: $Of,
            )*)?
            $($(
                $(#[doc = $meaning])+
                #[doc = concat!("\n\nThe scene's `", $path, "`.")]
                pub $shared: $Number,
            )*)?
        }

        impl Default for $Settings {
            fn default() -> Self {
                Self {
                    $($key: $default,)*
                    $($part: <$Part>::default(),)?
                    $($($constant: $always,)*)?
                    $($($shared: ::core::default::Default::default(),)*)?
                }
            }
        }

        impl $crate::settings::serde::Serialize for $Settings {
            fn serialize<S: $crate::settings::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::settings::Values::of(&mut self.clone()).serialize(serializer)
            }
        }

        $crate::settings! { @inputs $Settings [$($R)?] [
            $($key: $type, stringify!($key);)* $($($shared: $Number, $path;)*)?
        ] }

        impl $crate::settings::Settings for $Settings {
            fn about(&self) -> &'static str {
                concat!($($about),+).trim_ascii()
            }

            fn fields_of_cases(&mut self) -> Vec<$crate::settings::Field<'_>> {
                vec![$($crate::settings::Field {
                    key: stringify!($key),
                    doc: concat!($($doc),+).trim_ascii(),
                    unit: concat!("", $($unit)?),
                    auto: concat!("", $($auto)?),
                    source: $source,
                    when: concat!("", $($when)?),
                    is_read: {
                        let conditions: &[fn(&dyn std::any::Any) -> bool] =
                            &[$(|scene| $crate::settings::holds($is_read, scene),)? |_| true];
                        conditions[0]
                    },
                    limits: [$($limits,)? $crate::settings::Limits::NONE][0],
                    of_cases: false,
                    value: &mut self.$key,
                },)*
                $($($crate::settings::Field::of_cases(
                    stringify!($constant),
                    concat!($($says),+).trim_ascii(),
                    $origin,
                    &mut self.$constant,
                ),)*)?]
            }
            $(
                fn fill(&mut self, number: &dyn Fn(&str) -> f64) {
                    $(self.$shared = number($path);)*
                }
            )?
        }
    };
    (
        $(#[doc = $about:literal])+
        scene $Scene:ident over $Base:ty {
            $($(#[doc = $doc:literal])+ $section:ident: $Settings:ty
                $(, read $when:literal if $is_read:expr)?;)+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone)]
        pub struct $Scene {
            /// The built-in scene that supplied the keys that were missing in the file. Scenes with equal settings are
            /// equal even if their bases differ.
            pub base: $Base,
            /// The keys whose values follow from the robot and its world, such as `physics.dt`: their files say "auto".
            pub(crate) auto: std::collections::BTreeSet<String>,
            $($(#[doc = $doc])+ pub $section: $Settings,)+
        }

        impl PartialEq for $Scene {
            fn eq(&self, other: &Self) -> bool {
                true $(&& self.$section == other.$section)+
            }
        }

        impl $Scene {
            /// The scene in which every setting has its declared default.
            fn declared(base: $Base) -> Self {
                Self { base, auto: Default::default(), $($section: <$Settings>::default(),)+ }
            }

            /// Two things about a section: the condition under which scenes read it, as a phrase, and whether this
            /// scene does. The phrase is empty if every scene reads the section.
            fn section_is_read(&self, section: &str) -> (&'static str, bool) {
                match section {
                    $($(stringify!($section) => {
                        let is_read: fn(&Self) -> bool = $is_read;
                        ($when, is_read(self))
                    })?)+
                    _ => ("", true),
                }
            }

            /// Every section with its name, in the order in which a scene is written.
            fn sections(
                &mut self,
            ) -> [(&'static str, &mut dyn $crate::settings::Settings); [$(stringify!($section)),+].len()] {
                [$((stringify!($section), &mut self.$section),)+]
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
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $Choice {
            $($(#[$doc])+ $Member,)+
        }

        // This trait is implemented by hand, because a derive would require that the user's crate depends on serde.
        impl $crate::settings::serde::Serialize for $Choice {
            fn serialize<S: $crate::settings::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                serializer.serialize_str($crate::settings::Named::name(*self))
            }
        }

        impl<'de> $crate::settings::serde::Deserialize<'de> for $Choice {
            fn deserialize<D: $crate::settings::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                $crate::settings::member(deserializer, &[$($name),+])
            }
        }

        impl $crate::settings::Named for $Choice {
            const ALL: &'static [(&'static str, Self)] = &[$(($name, Self::$Member),)+];
        }
    };
    // For settings without inputs.
    (@inputs $Settings:ident [] $fields:tt) => {
        impl $crate::settings::StepInputs for $Settings {
            type Of<R: $crate::settings::Real> = Self;
            const COUNT: usize = 0;

            fn inputs(&self) -> Vec<(String, f64)> {
                Vec::new()
            }
            #[inline(always)]
            fn of<R: $crate::settings::Real>(&self, _: &[R]) -> Self {
                self.clone()
            }
        }
    };
    // For settings that are generic over their numbers. The macro receives the type and the key of each field.
    (@inputs $Settings:ident [$R:ident] [$($field:ident: $type:ty, $key:expr;)*]) => {
        impl $crate::settings::StepInputs for $Settings {
            type Of<$R: $crate::settings::Real> = $Settings<$R>;
            const COUNT: usize = {
                type $R = f64;
                0 $(+ <$type as $crate::settings::InputField<f64, $type>>::COUNT)*
            };

            fn inputs(&self) -> Vec<(String, f64)> {
                type $R = f64;
                [$(<$type as $crate::settings::InputField<f64, $type>>::inputs(&self.$field, $key)),*]
                    .concat()
            }
            #[inline(always)]
            fn of<$R: $crate::settings::Real>(&self, mut numbers: &[$R]) -> $Settings<$R> {
                $Settings {
                    $($field: $crate::settings::InputField::<$R, $type>::of(&self.$field, &mut numbers),)*
                }
            }
        }
    };
}
