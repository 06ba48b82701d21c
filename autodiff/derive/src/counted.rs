//! `impl Kernel<_, _>`: the numbers of inputs and results are those of what `eval` takes and returns.

use std::ops::Range;

use crate::fields::PACKAGE;
use crate::manifest::root;
use crate::tokens::{
    Angles, Delimiter, Group, Refusal, Span, TokenStream as Code, TokenTree, code, filled, is,
    is_group, is_punct, parts, replaced, unused,
};

/// Replaces every `_` in the trait of an `impl`, and in the signature of `vjp`, by the number of inputs or results. Then
/// `eval` takes and returns arrays of so many numbers. An `impl` whose trait has no `_` stays as it is.
pub(crate) fn counted(head: Vec<TokenTree>, body: Code) -> Result<(Vec<TokenTree>, Code), Refusal> {
    let trait_name = trait_of(&head);
    if !head[trait_name.clone()].iter().any(|token| is(token, "_")) {
        return Ok((head, body));
    }
    let (head, attributes) = without_path(head, trait_name.start);
    let trait_name = trait_of(&head);
    let root = root(PACKAGE, &attributes)?;
    let name = unused("numbers", &body);
    let tokens: Vec<TokenTree> = body.into_iter().collect();
    let Some(eval) = Eval::read(&tokens) else {
        let why = "in an `impl` with `_`, `eval` needs its inputs and its results";
        return Err(Refusal(Span::call_site(), why.into()));
    };
    let [inputs, results] = [&eval.given, &eval.results].map(|of| {
        // A count is a constant, which must not mention the number type of `eval`.
        let of = replaced(of.clone(), &[(&eval.number.to_string(), &code("f64"))]);
        filled(
            "{ <OF as ROOT::Fields<f64>>::COUNT }",
            &[("OF", &of), ("ROOT", &root)],
        )
    });
    let counts = [&inputs, &results, &inputs];
    let template = "
        (&self, NAME: [NUMBER; INPUTS], UNIFORMS) -> [NUMBER; RESULTS] {
            let PATTERN: GIVEN = <GIVEN as ROOT::Fields<NUMBER>>::first_of(&NAME);
            let NAME: FOUND = BODY;
            <FOUND as ROOT::Fields<NUMBER>>::array(NAME)
        }";
    let evaluated = filled(
        template,
        &[
            ("NAME", &code(&name)),
            ("NUMBER", &eval.number),
            ("INPUTS", &inputs),
            ("RESULTS", &results),
            ("UNIFORMS", &eval.uniforms),
            ("PATTERN", &eval.pattern),
            ("GIVEN", &eval.given),
            ("FOUND", &eval.results),
            ("ROOT", &root),
            ("BODY", &eval.body),
        ],
    );
    let mut counted: Vec<TokenTree> = tokens[..eval.place.start].to_vec();
    counted.extend(evaluated);
    counted.extend_from_slice(&tokens[eval.place.end..]);
    if let Some(vjp) = function(&counted, "vjp") {
        let signature = vjp.start..vjp.end - 1;
        let new = with_counts(&counted[signature.clone()], &mut counts.into_iter());
        counted.splice(signature, new);
    }
    let mut new_head = head[..trait_name.start].to_vec();
    new_head.extend(with_counts(
        &head[trait_name.clone()],
        &mut counts.into_iter(),
    ));
    new_head.extend_from_slice(&head[trait_name.end..]);
    Ok((new_head, counted.into_iter().collect()))
}

/// The parts of the function `eval`.
struct Eval {
    /// The number type.
    number: Code,
    /// The pattern and the type of the inputs.
    pattern: Code,
    given: Code,
    /// The last argument.
    uniforms: Code,
    /// The type of the results.
    results: Code,
    body: Code,
    /// Where the arguments begin and the function ends.
    place: Range<usize>,
}

impl Eval {
    /// Reads the function in the body of an `impl`.
    fn read(tokens: &[TokenTree]) -> Option<Self> {
        let place = function(tokens, "eval")?;
        let of = |tokens: &[TokenTree]| -> Code { tokens.iter().cloned().collect() };
        let mut angles = Angles::default();
        let is_arguments =
            |token: &TokenTree| angles.pass(token) == 0 && is_group(token, Delimiter::Parenthesis);
        let begin = place.start + tokens[place.clone()].iter().position(is_arguments)?;
        let [
            TokenTree::Group(arguments),
            minus,
            arrow,
            results @ ..,
            body,
        ] = &tokens[begin..place.end]
        else {
            return None;
        };
        if !is_punct(minus, '-') || !is_punct(arrow, '>') {
            return None;
        }
        let arguments: Vec<TokenTree> = arguments.stream().into_iter().collect();
        let [_, inputs, uniforms] = parts(&arguments, ',')[..] else {
            return None;
        };
        // Not one of the two colons of a path.
        let colon = (1..inputs.len()).find(|&k| {
            let is_colon = |k: usize| inputs.get(k).is_some_and(|token| is_punct(token, ':'));
            is_colon(k) && !is_colon(k - 1) && !is_colon(k + 1)
        })?;
        Some(Self {
            number: of(&tokens[place.start + 3..=place.start + 3]),
            pattern: of(&inputs[..colon]),
            given: of(&inputs[colon + 1..]),
            uniforms: of(uniforms),
            results: of(results),
            body: of(std::slice::from_ref(body)),
            place: begin..place.end,
        })
    }
}

/// Finds the function of this name in the body of an `impl`, from `fn` to its body.
fn function(tokens: &[TokenTree], name: &str) -> Option<Range<usize>> {
    let is_named = |pair: &[TokenTree]| is(&pair[0], "fn") && is(&pair[1], name);
    let begin = tokens.windows(2).position(is_named)?;
    let is_body = |token: &TokenTree| is_group(token, Delimiter::Brace);
    let end = begin + tokens[begin..].iter().position(is_body)?;
    Some(begin..end + 1)
}

/// Finds the trait in the head of an `impl`: what is between its generic parameters and `for`, without attributes. It is empty
/// if the `impl` has no trait.
fn trait_of(head: &[TokenTree]) -> Range<usize> {
    let (mut angles, mut begin) = (Angles::default(), 0);
    for (place, token) in head.iter().enumerate() {
        let depth = angles.pass(token);
        if is(token, "impl") {
            begin = place + 1;
        }
        if depth == 0 && is(token, "for") {
            return begin..place;
        }
        if is(token, "where") {
            break;
        }
    }
    begin..begin
}

/// Takes the attributes `#[autodiff(..)]` from the head of an `impl`, which only this macro understands.
fn without_path(head: Vec<TokenTree>, end: usize) -> (Vec<TokenTree>, Vec<Vec<TokenTree>>) {
    let (mut kept, mut taken) = (Vec::new(), Vec::new());
    for (place, token) in head.into_iter().enumerate() {
        if let TokenTree::Group(group) = &token {
            let inner: Vec<TokenTree> = group.stream().into_iter().collect();
            if place < end && inner.first().is_some_and(|first| is(first, "autodiff")) {
                kept.pop();
                taken.push(inner);
                continue;
            }
        }
        kept.push(token);
    }
    (kept, taken)
}

/// Replaces every `_` by the next count. The `_` of a lifetime stays.
fn with_counts<'a>(tokens: &[TokenTree], counts: &mut impl Iterator<Item = &'a Code>) -> Code {
    let (mut filled, mut is_lifetime) = (Code::new(), false);
    for token in tokens {
        let next = match token {
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                let inner = Group::new(group.delimiter(), with_counts(&inner, counts));
                Some(TokenTree::from(inner).into())
            }
            token if is(token, "_") && !is_lifetime => counts.next().cloned(),
            _ => None,
        };
        filled.extend(next.unwrap_or_else(|| token.clone().into()));
        is_lifetime = is_punct(token, '\'');
    }
    filled
}
