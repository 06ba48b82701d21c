//! `#[derive(Parameters)]` for structures of numbers. The trait in `autodiff` has the documentation. And `#[kernel]` for
//! functions that run in SIMD lanes.

mod kernel;

use proc_macro::TokenStream;
use proc_macro2::{TokenStream as Code, TokenTree};
use quote::{ToTokens, format_ident, quote};
use syn::ext::IdentExt;
use syn::{Data, DeriveInput, Error, Field, Fields, GenericParam, Generics, Ident, LitStr, Path};

/// Implements `autodiff::Parameters` for a struct with one type parameter, the number type. The struct
/// may also have lifetime and constant parameters. Fields whose type does not mention the number type
/// are cloned.
///
/// The code finds the name of the dependency `cosmic-autodiff` in the manifest. `#[autodiff(crate = "path")]` names
/// another path, for example of a crate that exports it.
#[proc_macro_derive(Parameters, attributes(autodiff))]
pub fn parameters(input: TokenStream) -> TokenStream {
    let input = syn::parse_macro_input!(input as DeriveInput);
    implementation(&input)
        .unwrap_or_else(Error::into_compile_error)
        .into()
}

/// Marks every function of an `impl` `#[inline(always)]`, or a single function: those that run in SIMD lanes.
///
/// The instruction set of the lanes is chosen at run time, for the loop around a kernel. A function that is not inlined
/// into that loop is compiled without this instruction set, and every operation in it becomes a call: the results stay
/// the same, but the kernel takes some fifty times as long. So the traits of kernels have a hidden constant, which this
/// attribute defines, and an `impl` without it does not compile. Use it also on all functions of yours that a kernel
/// calls, or on their `impl`. In an `impl` of any other trait, mark the functions one by one. Closures cannot be marked,
/// so prefer loops.
#[proc_macro_attribute]
pub fn kernel(arguments: TokenStream, item: TokenStream) -> TokenStream {
    kernel::marked(&arguments.into(), item.into())
        .unwrap_or_else(Error::into_compile_error)
        .into()
}

fn implementation(input: &DeriveInput) -> Result<Code, Error> {
    let name = &input.ident;
    let Data::Struct(data) = &input.data else {
        let refused = "Parameters can only be derived for structs; enums and unions have no fixed number \
                       of parameters";
        return Err(Error::new(name.span(), refused));
    };
    let (number, root) = (number(input)?, root(input)?);
    let (other, walk) = (unused("Other", input), unused("walk", input));
    let fields = data.fields.iter().enumerate();
    let fields = fields.map(|(place, field)| replaced(place, field, number, &walk));
    let body = match data.fields {
        Fields::Unit => quote! {},
        _ => quote! { #(#fields),* },
    };
    let of_other = with(&input.generics, number, &other);
    let mut generics = input.generics.clone();
    for parameter in generics.type_params_mut() {
        parameter.bounds.push(syn::parse_quote!(#root::Real));
    }
    let (parameters, arguments, conditions) = generics.split_for_impl();
    Ok(quote! {
        impl #parameters #root::Parameters<#number> for #name #arguments #conditions {
            type With<#other: #root::Real> = #name<#(#of_other),*>;
            fn map_numbers<#other: #root::Real>(
                &self,
                #walk: &mut #root::parameters::Walk<'_, #number, #other>,
            ) -> #name<#(#of_other),*> {
                #name { #body }
            }
        }
    })
}

/// Returns the path of the crate `autodiff` in the user's code.
fn root(input: &DeriveInput) -> Result<Path, Error> {
    let mut root = None;
    for attribute in (input.attrs.iter()).filter(|attribute| attribute.path().is_ident("autodiff"))
    {
        attribute.parse_nested_meta(|meta| {
            if !meta.path.is_ident("crate") {
                return Err(meta.error("unknown key; expected `crate = \"path\"`"));
            }
            root = Some(meta.value()?.parse::<LitStr>()?.parse()?);
            Ok(())
        })?;
    }
    Ok(root.unwrap_or_else(|| {
        let name = format_ident!("{}", dependency().unwrap_or_else(|| "autodiff".into()));
        syn::parse_quote!(::#name)
    }))
}

/// Returns the name that the user's manifest gives to the package, if it gives one.
fn dependency() -> Option<String> {
    let folder = std::env::var_os("CARGO_MANIFEST_DIR")?;
    let manifest = std::fs::read_to_string(std::path::Path::new(&folder).join("Cargo.toml"));
    renamed(&manifest.ok()?)
}

/// Finds the package in the text of a manifest: `name = { package = "cosmic-autodiff" }` on one line, or this line in a
/// section `[dependencies.name]`. If it has several names, prefers the usual one.
fn renamed(manifest: &str) -> Option<String> {
    let (mut section, mut found) = ("", None);
    for line in manifest.lines().map(str::trim) {
        if let Some(header) = line.strip_prefix('[') {
            section = header.trim_end_matches(']');
        }
        let words: String = line.split_whitespace().collect();
        if line.starts_with('#') || !words.contains("package=\"cosmic-autodiff\"") {
            continue;
        }
        let name = match words.starts_with("package=") {
            true => section.rsplit_once("dependencies.")?.1,
            false => words.split_once('=')?.0,
        };
        let name = name.trim_matches('"').replace('-', "_");
        if name == "autodiff" || found.is_none() {
            found = Some(name);
        }
    }
    found
}

/// Generates the expression that copies a field into the struct with the other number type.
fn replaced(place: usize, field: &Field, number: &Ident, walk: &Ident) -> Code {
    let (member, text) = match &field.ident {
        Some(ident) => (ident.to_token_stream(), ident.unraw().to_string()),
        None => (syn::Index::from(place).to_token_stream(), place.to_string()),
    };
    if mentions(field.ty.to_token_stream(), number) {
        quote! { #member: #walk.field(#text, &self.#member) }
    } else {
        quote! { #member: ::core::clone::Clone::clone(&self.#member) }
    }
}

/// Returns the only type parameter of the struct.
fn number(input: &DeriveInput) -> Result<&Ident, Error> {
    let mut types = input.generics.type_params();
    match (types.next(), types.count()) {
        (Some(number), 0) => Ok(&number.ident),
        (found, more) => Err(Error::new(
            input.ident.span(),
            format!(
                "Parameters needs a struct with one type parameter, the type of its numbers; `{}` has {}",
                input.ident,
                usize::from(found.is_some()) + more
            ),
        )),
    }
}

/// Generates the generic arguments of the struct, with another type in place of the number type.
fn with(generics: &Generics, number: &Ident, other: &Ident) -> Vec<Code> {
    let argument = |parameter: &GenericParam| match parameter {
        GenericParam::Lifetime(lifetime) => lifetime.lifetime.to_token_stream(),
        GenericParam::Const(constant) => constant.ident.to_token_stream(),
        GenericParam::Type(of) if of.ident == *number => other.to_token_stream(),
        GenericParam::Type(of) => of.ident.to_token_stream(),
    };
    generics.params.iter().map(argument).collect()
}

/// Returns a name that does not occur in the struct.
fn unused(name: &str, input: &DeriveInput) -> Ident {
    let mut unused = format_ident!("{name}");
    while any(input.to_token_stream(), &|token, _| *token == unused) {
        unused = format_ident!("{unused}x");
    }
    unused
}

/// Whether a type uses the number type. A lifetime or a part of a path with the same name does not count.
fn mentions(of: Code, number: &Ident) -> bool {
    any(of, &|token, before| {
        *token == *number && !before.ends_with('\'') && !before.ends_with("::")
    })
}

/// Whether `test` is true for any identifier in the code. `test` receives the identifier and the punctuation before it.
fn any(code: Code, test: &impl Fn(&Ident, &str) -> bool) -> bool {
    let mut before = String::new();
    code.into_iter().any(|token| {
        let found = match &token {
            TokenTree::Ident(ident) => test(ident, &before),
            TokenTree::Group(group) => any(group.stream(), test),
            _ => false,
        };
        match token {
            TokenTree::Punct(punct) => before.push(punct.as_char()),
            _ => before.clear(),
        }
        found
    })
}

#[cfg(test)]
mod tests {
    use super::{implementation, renamed};
    use syn::{DeriveInput, parse_quote};

    fn refused(input: &DeriveInput) -> String {
        let found = implementation(input).map(|code| code.to_string());
        found.expect_err("a refusal").to_string()
    }

    #[test]
    fn the_manifest_may_rename_the_package() {
        let of = |manifest: &str| renamed(manifest);
        let line = "[dependencies]\nrand = \"1\"\nad-core = { version = \"0.1\", package = \"cosmic-autodiff\" }";
        assert_eq!(of(line).as_deref(), Some("ad_core"));
        let section = "[package]\nname = \"x\"\n[dependencies.ad]\npackage = \"cosmic-autodiff\"\npath = \"..\"";
        assert_eq!(of(section).as_deref(), Some("ad"));
        let both = format!("{line}\nautodiff = {{ package=\"cosmic-autodiff\" }}");
        assert_eq!(of(&both).as_deref(), Some("autodiff"));
        assert_eq!(of("[dependencies]\ncosmic-autodiff = \"0.1\""), None);
        // The package of programs is another one, before or after this one.
        let programs = "steps = { package = \"cosmic-autodiff-programs\", path = \"..\" }";
        assert_eq!(of(&format!("[dependencies]\n{programs}")), None);
        for pair in [
            format!("{line}\n{programs}"),
            line.replace("rand = \"1\"", programs),
        ] {
            assert_eq!(of(&pair).as_deref(), Some("ad_core"), "{pair}");
        }
    }

    #[test]
    fn an_attribute_names_the_crate() {
        let code = implementation(&parse_quote! {
            #[autodiff(crate = "outer::ad")]
            struct Layer<R> { x: R }
        });
        let code = code.expect("a struct with one type parameter").to_string();
        assert!(code.contains("impl < R : outer :: ad :: Real >"), "{code}");
        assert!(!code.contains("autodiff"), "{code}");
        let says = refused(&parse_quote! { #[autodiff(root = "ad")] struct Layer<R> { x: R } });
        assert!(says.contains("expected `crate"), "{says}");
    }

    #[test]
    fn a_struct_without_one_type_parameter_is_refused_by_name() {
        let says = "one type parameter, the type of its numbers; `Layer` has";
        let none = refused(&parse_quote! { struct Layer<'a, const N: usize> { x: &'a [f64; N] } });
        assert!(none.contains(&format!("{says} 0")), "{none}");
        let two = refused(&parse_quote! { struct Layer<R, T> { x: R, y: T } });
        assert!(two.contains(&format!("{says} 2")), "{two}");
        for input in [
            parse_quote! { enum Layer<R> { One(R), Two(R) } },
            parse_quote! { union Layer<R: Copy> { x: R } },
        ] {
            let says = refused(&input);
            assert!(says.contains("derived for structs"), "{says}");
        }
    }
}
