//! `#[kernel]`.

use crate::counted::counted;
use crate::tokens::{
    Angles, Delimiter, Group, Refusal, Span, TokenStream as Code, TokenTree, code, is, is_group,
    is_punct,
};

/// Marks an `impl` or a function.
pub(crate) fn marked(arguments: &Code, item: Code) -> Result<Code, Refusal> {
    let refused = |why: &str| Err(Refusal(Span::call_site(), why.into()));
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
    let (mut tokens, functions) = counted(tokens, body.stream())?;
    let mut functions = all_inlined(functions);
    if implements_a_trait(&tokens) {
        functions.extend(code("const USE_THE_ATTRIBUTE_KERNEL: () = ();"));
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
        let is_end = is_group(&token, Delimiter::Brace) || is_punct(&token, ';');
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
    let mut marked = code("#[inline(always)]");
    let mut tokens = function.into_iter().peekable();
    while let Some(token) = tokens.next() {
        let is_inline = |next: &TokenTree| match next {
            TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket => {
                let first = group.stream().into_iter().next();
                first.is_some_and(|first| is(&first, "inline"))
            }
            _ => false,
        };
        if !is_punct(&token, '#') || tokens.next_if(is_inline).is_none() {
            marked.extend([token]);
        }
    }
    marked
}

/// Whether the head of an `impl` has `for` between a trait and a type: not the `for` of `for<'a>`, which stands between
/// angle brackets or after `where`.
fn implements_a_trait(head: &[TokenTree]) -> bool {
    let mut angles = Angles::default();
    for token in head {
        if angles.pass(token) == 0 && is(token, "for") {
            return true;
        }
        if is(token, "where") {
            return false;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::marked;
    use crate::tokens::{code, replaced};

    fn kernel(item: &str) -> String {
        let marked = marked(&code(""), code(item)).map_err(|refusal| refusal.1);
        marked.expect("an `impl` or a function").to_string()
    }

    #[test]
    fn all_functions_of_an_impl_are_inlined_once() {
        let found = kernel(
            "impl<F: for<'a> Fn(&'a f64) -> R, R> Kernel<{ N + 1 }, 1> for Spring<F>
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
            }",
        );
        let expected = code(
            "impl<F: for<'a> Fn(&'a f64) -> R, R> Kernel<{ N + 1 }, 1> for Spring<F>
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
            }",
        );
        assert_eq!(found, expected.to_string());
    }

    #[test]
    fn functions_and_impls_without_a_trait_get_no_constant() {
        let function = "#[inline] pub fn pull<R: Real>(x: R) -> impl Sized { x }";
        let marked = function.replace("#[inline]", "#[inline(always)]");
        assert_eq!(kernel(function), code(&marked).to_string());
        let own = kernel(
            "impl<F: for<'a> Fn(&'a f64)> Own<F> where F: for<'a> Fn(&'a f64) { fn f() {} }",
        );
        assert!(own.contains("# [inline (always)] fn f"), "{own}");
        assert!(!own.contains("USE_THE"), "{own}");
    }

    #[test]
    fn numbers_of_inputs_and_results_are_counted() {
        let found = kernel(
            "#[autodiff(crate = \"ad\")]
            impl<L: Law<'_>> Kernel<_, _> for Spring<L> {
                const UNIFORMS: usize = L::COUNT;
                fn eval<R: Real>(&self, ad::Given { x, k }: Given<R, D>, numbers: &[R]) -> R { x * k }
                fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
                    let _ = at;
                }
            }",
        );
        let expected = code(
            "impl<L: Law<'_>> Kernel<INPUTS, RESULTS> for Spring<L> {
                const UNIFORMS: usize = L::COUNT;
                #[inline(always)]
                fn eval<R: Real>(&self, numbersx: [R; INPUTS], numbers: &[R]) -> [R; RESULTS] {
                    let ad::Given { x, k }: Given<R, D> = <Given<R, D> as ad::Fields<R>>::first_of(&numbersx);
                    let numbersx: R = { x * k };
                    <R as ad::Fields<R>>::array(numbersx)
                }
                #[inline(always)]
                fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, INPUTS, RESULTS, M>) -> [[R; INPUTS]; M] {
                    let _ = at;
                }
                const USE_THE_ATTRIBUTE_KERNEL: () = ();
            }",
        );
        let counts = [
            ("INPUTS", "{ <Given<f64, D> as ad::Fields<f64>>::COUNT }"),
            ("RESULTS", "{ <f64 as ad::Fields<f64>>::COUNT }"),
        ];
        let counts = counts.map(|(key, count)| (key, code(count)));
        let counts = [0, 1].map(|k| (counts[k].0, &counts[k].1));
        let of = |code: String| -> String { code.split_whitespace().collect() };
        assert_eq!(of(found), of(replaced(expected, &counts).to_string()));
    }

    #[test]
    fn anything_else_is_refused() {
        let refused = |arguments: &str, item: &str| {
            let marked = marked(&code(arguments), code(item)).map(|code| code.to_string());
            marked.map_err(|refusal| refusal.1).expect_err("a refusal")
        };
        let says = refused("", "struct Spring;");
        assert!(says.contains("belongs on an `impl`"), "{says}");
        let says = refused("", "impl Kernel<_, _> for Spring { fn eval(&self) {} }");
        assert!(says.contains("its inputs and its results"), "{says}");
        let says = refused("inline", "fn f() {}");
        assert!(says.contains("no arguments"), "{says}");
    }
}
