//! `#[derive(Parameters)]` for structures of numbers; documented with the trait in `autodiff`.

use proc_macro::TokenStream;
use proc_macro2::{TokenStream as Code, TokenTree};
use quote::{ToTokens, quote};
use syn::{Data, DeriveInput, Error, Fields, Ident, Type};

/// Implements `autodiff::Parameters` for a struct with one type parameter, the number. Fields whose type
/// does not mention it are cloned.
#[proc_macro_derive(Parameters)]
pub fn parameters(input: TokenStream) -> TokenStream {
    let input = syn::parse_macro_input!(input as DeriveInput);
    implementation(&input)
        .unwrap_or_else(Error::into_compile_error)
        .into()
}

fn implementation(input: &DeriveInput) -> Result<Code, Error> {
    let name = &input.ident;
    let number = number(input)?;
    let Data::Struct(data) = &input.data else {
        let refused =
            "Parameters can be derived for structs; an enum has no fixed number of parameters";
        return Err(Error::new(name.span(), refused));
    };
    let fields = data.fields.iter().enumerate().map(|(place, field)| {
        let member = match &field.ident {
            Some(ident) => ident.to_token_stream(),
            None => syn::Index::from(place).to_token_stream(),
        };
        let text = member.to_string();
        if mentions(&field.ty, number) {
            quote! { #member: walk.field(#text, &self.#member) }
        } else {
            quote! { #member: ::core::clone::Clone::clone(&self.#member) }
        }
    });
    let body = match data.fields {
        Fields::Unit => quote! {},
        _ => quote! { #(#fields),* },
    };
    Ok(quote! {
        impl<#number: ::autodiff::Real> ::autodiff::Parameters<#number> for #name<#number> {
            type With<S: ::autodiff::Real> = #name<S>;
            fn map<S: ::autodiff::Real>(
                &self,
                walk: &mut ::autodiff::parameters::Walk<'_, #number, S>,
            ) -> #name<S> {
                #name { #body }
            }
        }
    })
}

/// The one generic parameter.
fn number(input: &DeriveInput) -> Result<&Ident, Error> {
    let mut types = input.generics.type_params();
    match (types.next(), input.generics.params.len()) {
        (Some(number), 1) => Ok(&number.ident),
        _ => Err(Error::new(
            input.ident.span(),
            "Parameters needs a struct with one generic parameter, the type of its numbers",
        )),
    }
}

fn mentions(ty: &Type, number: &Ident) -> bool {
    fn within(code: Code, number: &Ident) -> bool {
        code.into_iter().any(|token| match token {
            TokenTree::Ident(ident) => ident == *number,
            TokenTree::Group(group) => within(group.stream(), number),
            _ => false,
        })
    }
    within(ty.to_token_stream(), number)
}
