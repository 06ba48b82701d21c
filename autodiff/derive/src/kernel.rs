//! `#[kernel]` on tokens: the parser of `syn` for functions would take longer to compile than all the rest.

use proc_macro2::{Delimiter, Group, Span, TokenStream as Code, TokenTree};
use quote::quote;
use syn::Error;

/// Marks an `impl` or a function.
pub(crate) fn marked(arguments: &Code, item: Code) -> Result<Code, Error> {
    let refused = |why| Err(Error::new(Span::call_site(), why));
    if !arguments.is_empty() {
        return refused("`#[kernel]` has no arguments");
    }
    let mut tokens: Vec<TokenTree> = item.into_iter().collect();
    let is_keyword = |token: &&TokenTree| is(token, "impl") || is(token, "fn");
    match tokens.iter().find(is_keyword) {
        Some(keyword) if is(keyword, "fn") => return Ok(inlined(tokens)),
        Some(_) => {}
        None => return refused("`#[kernel]` belongs on an `impl` or on a function"),
    }
    let Some(TokenTree::Group(body)) = tokens.pop() else {
        return refused("this `impl` has no body");
    };
    let mut functions = all_inlined(body.stream());
    if implements_a_trait(&tokens) {
        functions.extend(quote! { const USE_THE_ATTRIBUTE_KERNEL: () = (); });
    }
    let mut block = Group::new(Delimiter::Brace, functions);
    block.set_span(body.span());
    tokens.push(block.into());
    Ok(tokens.into_iter().collect())
}

/// Marks every function of an `impl`.
fn all_inlined(body: Code) -> Code {
    let (mut marked, mut item) = (Code::new(), Vec::new());
    for token in body {
        let is_end = match &token {
            TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
            TokenTree::Punct(punct) => punct.as_char() == ';',
            _ => false,
        };
        item.push(token);
        if is_end {
            // Not a type such as `fn(f64)`.
            let named =
                |pair: &[TokenTree]| is(&pair[0], "fn") && matches!(pair[1], TokenTree::Ident(_));
            let item = std::mem::take(&mut item);
            match item.windows(2).any(named) {
                true => marked.extend(inlined(item)),
                false => marked.extend(item),
            }
        }
    }
    marked.extend(item);
    marked
}

/// Marks a function. Any `#[inline]` of its own is removed.
fn inlined(function: Vec<TokenTree>) -> Code {
    let mut marked = quote! { #[inline(always)] };
    let mut tokens = function.into_iter().peekable();
    while let Some(token) = tokens.next() {
        let is_inline = |next: &TokenTree| match next {
            TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket => {
                let first = group.stream().into_iter().next();
                first.is_some_and(|first| is(&first, "inline"))
            }
            _ => false,
        };
        let is_hash = matches!(&token, TokenTree::Punct(punct) if punct.as_char() == '#');
        if !is_hash || tokens.next_if(is_inline).is_none() {
            marked.extend([token]);
        }
    }
    marked
}

/// Whether the head of an `impl` has `for` between a trait and a type: not the `for` of `for<'a>`, which stands between
/// angle brackets or after `where`.
fn implements_a_trait(head: &[TokenTree]) -> bool {
    let (mut depth, mut before) = (0, ' ');
    for token in head {
        let TokenTree::Punct(punct) = token else {
            if depth == 0 && is(token, "for") {
                return true;
            }
            if is(token, "where") {
                return false;
            }
            before = ' ';
            continue;
        };
        match punct.as_char() {
            '<' => depth += 1,
            '>' if before != '-' => depth -= 1,
            _ => {}
        }
        before = punct.as_char();
    }
    false
}

fn is(token: &TokenTree, word: &str) -> bool {
    matches!(token, TokenTree::Ident(ident) if ident == word)
}

#[cfg(test)]
mod tests {
    use super::marked;
    use proc_macro2::TokenStream as Code;
    use quote::quote;

    fn kernel(item: Code) -> String {
        let marked = marked(&Code::new(), item);
        marked.expect("an `impl` or a function").to_string()
    }

    #[test]
    fn all_functions_of_an_impl_are_inlined_once() {
        let code = kernel(quote! {
            impl<F: for<'a> Fn(&'a f64) -> R, R> Kernel<{ N + 1 }, 1> for Spring<F>
            where
                F: for<'a> Fn(&'a f64),
            {
                const RULE: fn(f64) -> f64 = f64::sin;
                type Of<R> = Vec<R>;
                /// The first.
                #[must_use]
                fn eval<R: Real>(&self, x: [R; { N + 1 }]) -> Array<{ N + 1 }> {
                    fn inner() {}
                    x
                }
                emitted!(_);
                #[inline(always)]
                fn twice(self) -> Self { self }
                #[inline]
                #[track_caller]
                pub const unsafe fn weak() {}
            }
        });
        assert_eq!(
            code,
            quote! {
                impl<F: for<'a> Fn(&'a f64) -> R, R> Kernel<{ N + 1 }, 1> for Spring<F>
                where
                    F: for<'a> Fn(&'a f64),
                {
                    const RULE: fn(f64) -> f64 = f64::sin;
                    type Of<R> = Vec<R>;
                    #[inline(always)]
                    /// The first.
                    #[must_use]
                    fn eval<R: Real>(&self, x: [R; { N + 1 }]) -> Array<{ N + 1 }> {
                        fn inner() {}
                        x
                    }
                    emitted!(_);
                    #[inline(always)]
                    fn twice(self) -> Self { self }
                    #[inline(always)]
                    #[track_caller]
                    pub const unsafe fn weak() {}
                    const USE_THE_ATTRIBUTE_KERNEL: () = ();
                }
            }
            .to_string()
        );
    }

    #[test]
    fn functions_and_impls_without_a_trait_get_no_constant() {
        let function = quote! { #[inline] pub fn pull<R: Real>(x: R) -> impl Sized { x } };
        let marked = quote! { #[inline(always)] pub fn pull<R: Real>(x: R) -> impl Sized { x } };
        assert_eq!(kernel(function), marked.to_string());
        let own = kernel(
            quote! { impl<F: for<'a> Fn(&'a f64)> Own<F> where F: for<'a> Fn(&'a f64) { fn f() {} } },
        );
        assert!(own.contains("# [inline (always)] fn f"), "{own}");
        assert!(!own.contains("USE_THE"), "{own}");
    }

    #[test]
    fn anything_else_is_refused() {
        let refused = |arguments: Code, item: Code| {
            let marked = marked(&arguments, item).map(|code| code.to_string());
            marked.expect_err("a refusal").to_string()
        };
        let says = refused(Code::new(), quote! { struct Spring; });
        assert!(says.contains("belongs on an `impl`"), "{says}");
        let says = refused(quote! { inline }, quote! { fn f() {} });
        assert!(says.contains("no arguments"), "{says}");
    }
}
