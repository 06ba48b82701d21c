//! `#[derive(Parameters)]` for structures of numbers. The trait in `autodiff` has the documentation.

use proc_macro::TokenStream;
use proc_macro2::{TokenStream as Code, TokenTree};
use quote::{ToTokens, format_ident, quote};
use syn::ext::IdentExt;
use syn::{Data, DeriveInput, Error, Field, Fields, GenericParam, Generics, Ident};

/// Implements `autodiff::Parameters` for a struct with one type parameter, the number type. The struct
/// may also have lifetime and constant parameters. Fields whose type does not mention the number type
/// are cloned.
#[proc_macro_derive(Parameters)]
pub fn parameters(input: TokenStream) -> TokenStream {
    let input = syn::parse_macro_input!(input as DeriveInput);
    implementation(&input)
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
    let number = number(input)?;
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
        parameter.bounds.push(syn::parse_quote!(::autodiff::Real));
    }
    let (parameters, arguments, conditions) = generics.split_for_impl();
    Ok(quote! {
        impl #parameters ::autodiff::Parameters<#number> for #name #arguments #conditions {
            type With<#other: ::autodiff::Real> = #name<#(#of_other),*>;
            fn map_numbers<#other: ::autodiff::Real>(
                &self,
                #walk: &mut ::autodiff::parameters::Walk<'_, #number, #other>,
            ) -> #name<#(#of_other),*> {
                #name { #body }
            }
        }
    })
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
    use super::implementation;
    use syn::{DeriveInput, parse_quote};

    fn refused(input: &DeriveInput) -> String {
        let found = implementation(input).map(|code| code.to_string());
        found.expect_err("a refusal").to_string()
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
