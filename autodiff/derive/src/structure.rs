//! The parts of a struct that a derived implementation repeats.

use crate::tokens::{
    Angles, Delimiter, Ident, Refusal, Span, TokenStream, TokenTree, code, is, is_group, is_punct,
    parts,
};

/// A struct.
pub(crate) struct Structure {
    pub(crate) name: Ident,
    pub(crate) parameters: Vec<Parameter>,
    /// The clause `where`, or nothing.
    pub(crate) conditions: TokenStream,
    pub(crate) fields: Vec<Field>,
    /// What is in the brackets of each attribute.
    pub(crate) attributes: Vec<Vec<TokenTree>>,
}

/// A generic parameter.
pub(crate) struct Parameter {
    pub(crate) kind: Kind,
    /// How the parameter is named as an argument: with the apostrophe of a lifetime.
    pub(crate) argument: TokenStream,
    /// The declaration without attributes and without a default.
    pub(crate) declared: TokenStream,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Lifetime,
    Constant,
    Type,
}

/// A field.
pub(crate) struct Field {
    /// Its name, or its number.
    pub(crate) member: String,
    /// Its type.
    pub(crate) of: TokenStream,
}

impl Structure {
    /// Reads a struct. An enum or a union is refused with these words.
    pub(crate) fn read(input: TokenStream, refusal: &str) -> Result<Self, Refusal> {
        let tokens = flat(input);
        let (attributes, rest) = attributes(&tokens);
        let keyword = (rest.iter()).position(|token| {
            ["struct", "enum", "union"]
                .iter()
                .any(|word| is(token, word))
        });
        let Some((keyword, [TokenTree::Ident(name), rest @ ..])) =
            keyword.map(|at| (&rest[at], &rest[at + 1..]))
        else {
            return Err(Refusal(Span::call_site(), refusal.into()));
        };
        if !is(keyword, "struct") {
            return Err(Refusal(name.span(), refusal.into()));
        }
        let (parameters, rest) = generics(rest);
        let (fields, conditions) = body(rest);
        Ok(Self {
            name: name.clone(),
            parameters,
            conditions: conditions.iter().cloned().collect(),
            fields,
            attributes,
        })
    }

    /// Returns the only type parameter. `derived` is the name of the trait, for the refusal.
    pub(crate) fn number(&self, derived: &str) -> Result<TokenStream, Refusal> {
        let is_type = |parameter: &&Parameter| parameter.kind == Kind::Type;
        let types: Vec<&Parameter> = self.parameters.iter().filter(is_type).collect();
        match &types[..] {
            [number] => Ok(number.argument.clone()),
            _ => Err(Refusal(
                self.name.span(),
                format!(
                    "{derived} needs a struct with one type parameter, the type of its numbers; `{}` has {}",
                    self.name,
                    types.len()
                ),
            )),
        }
    }

    /// Returns the parameters as arguments, with this number type.
    pub(crate) fn with(&self, number: &TokenStream) -> TokenStream {
        self.listed(|parameter| match parameter.kind {
            Kind::Type => number.clone(),
            _ => parameter.argument.clone(),
        })
    }

    /// Returns the declarations of the parameters. The number type gets one more bound.
    pub(crate) fn declared(&self, bound: &TokenStream) -> TokenStream {
        self.listed(|parameter| {
            let mut declared = parameter.declared.clone();
            if parameter.kind == Kind::Type {
                let tokens: Vec<TokenTree> = declared.clone().into_iter().collect();
                let before = match tokens.last() {
                    _ if tokens.len() == 1 => ":",
                    Some(last) if is_punct(last, '+') || is_punct(last, ':') => "",
                    _ => "+",
                };
                declared.extend([code(before), bound.clone()]);
            }
            declared
        })
    }

    /// Returns the code of every parameter, with commas.
    fn listed(&self, of: impl Fn(&Parameter) -> TokenStream) -> TokenStream {
        let mut list = TokenStream::new();
        for parameter in &self.parameters {
            list.extend([of(parameter), code(",")]);
        }
        list
    }
}

/// The tokens, with those of groups that a macro made without delimiters.
fn flat(tokens: TokenStream) -> Vec<TokenTree> {
    let mut flattened = Vec::new();
    for token in tokens {
        match token {
            TokenTree::Group(group) if group.delimiter() == Delimiter::None => {
                flattened.extend(flat(group.stream()));
            }
            token => flattened.push(token),
        }
    }
    flattened
}

/// Takes the attributes from the beginning of tokens.
fn attributes(mut tokens: &[TokenTree]) -> (Vec<Vec<TokenTree>>, &[TokenTree]) {
    let mut attributes = Vec::new();
    while let [hash, TokenTree::Group(group), rest @ ..] = tokens {
        if !is_punct(hash, '#') {
            break;
        }
        attributes.push(group.stream().into_iter().collect());
        tokens = rest;
    }
    (attributes, tokens)
}

/// Takes the generic parameters from the beginning of tokens.
fn generics(tokens: &[TokenTree]) -> (Vec<Parameter>, &[TokenTree]) {
    if !tokens.first().is_some_and(|token| is_punct(token, '<')) {
        return (Vec::new(), tokens);
    }
    let mut angles = Angles::default();
    let end = tokens.iter().position(|token| angles.pass(token) == 0);
    let end = end.unwrap_or(tokens.len() - 1);
    let list = parts(&tokens[1..end], ',');
    (
        list.into_iter().map(parameter).collect(),
        &tokens[end + 1..],
    )
}

fn parameter(tokens: &[TokenTree]) -> Parameter {
    let (_, tokens) = attributes(tokens);
    let declared = parts(tokens, '=').first().copied().unwrap_or_default();
    let (kind, argument) = match declared {
        [first, ..] if is_punct(first, '\'') => (Kind::Lifetime, &declared[..2]),
        [first, ..] if is(first, "const") => (Kind::Constant, &declared[1..2]),
        _ => (Kind::Type, &declared[..1]),
    };
    Parameter {
        kind,
        argument: argument.iter().cloned().collect(),
        declared: declared.iter().cloned().collect(),
    }
}

/// Returns the fields, and the clause `where`.
fn body(tokens: &[TokenTree]) -> (Vec<Field>, &[TokenTree]) {
    match tokens {
        [TokenTree::Group(group), rest @ .., _] if group.delimiter() == Delimiter::Parenthesis => {
            let tokens: Vec<TokenTree> = group.stream().into_iter().collect();
            let field = |(place, field): (usize, &[TokenTree])| Field {
                member: place.to_string(),
                of: visible(attributes(field).1).iter().cloned().collect(),
            };
            let fields = parts(&tokens, ',').into_iter().enumerate().map(field);
            (fields.collect(), rest)
        }
        [rest @ .., TokenTree::Group(group)] if group.delimiter() == Delimiter::Brace => {
            let tokens = flat(group.stream());
            let fields = parts(&tokens, ',').into_iter().filter_map(named);
            (fields.collect(), rest)
        }
        [rest @ .., _] => (Vec::new(), rest),
        [] => (Vec::new(), &[]),
    }
}

/// The type of a field without name, behind its visibility. The parentheses of `pub (u8, u8)` are the type.
fn visible(field: &[TokenTree]) -> &[TokenTree] {
    match field {
        [first, second, rest @ ..]
            if is(first, "pub") && is_group(second, Delimiter::Parenthesis) && !rest.is_empty() =>
        {
            rest
        }
        [first, rest @ ..] if is(first, "pub") => rest,
        _ => field,
    }
}

fn named(field: &[TokenTree]) -> Option<Field> {
    let (_, field) = attributes(field);
    let colon = field.iter().position(|token| is_punct(token, ':'))?;
    let TokenTree::Ident(name) = field[..colon].last()? else {
        return None;
    };
    Some(Field {
        member: name.to_string(),
        of: field[colon + 1..].iter().cloned().collect(),
    })
}
