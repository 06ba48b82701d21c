//! Tokens without a parser. This crate depends on no other, because every user of derivatives waits for it.

// Outside of the compiler, where unit tests run, only the types of `proc-macro2` work.
#[cfg(not(test))]
pub(crate) use proc_macro::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};
#[cfg(test)]
pub(crate) use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};

/// Why a macro refuses its input, and where.
pub(crate) struct Refusal(pub(crate) Span, pub(crate) String);

impl Refusal {
    /// Returns code that makes the compiler report the refusal.
    pub(crate) fn into_code(self) -> TokenStream {
        let Self(span, why) = self;
        let error = code(&format!("::core::compile_error!({why:?});"));
        let here = |mut token: TokenTree| {
            token.set_span(span);
            token
        };
        error.into_iter().map(here).collect()
    }
}

/// Parses a piece of code.
pub(crate) fn code(text: &str) -> TokenStream {
    text.parse().expect("this macro writes whole tokens")
}

/// Parses a piece of code, and replaces each identifier that is a key by its value.
pub(crate) fn filled(template: &str, values: &[(&str, &TokenStream)]) -> TokenStream {
    replaced(code(template), values)
}

/// Replaces each identifier that is a key by its value.
pub(crate) fn replaced(tokens: TokenStream, values: &[(&str, &TokenStream)]) -> TokenStream {
    let mut filled = TokenStream::new();
    for token in tokens {
        let value = values.iter().find(|(key, _)| is(&token, key));
        match (value, token) {
            (Some((_, value)), _) => filled.extend((*value).clone()),
            (None, TokenTree::Group(group)) => {
                let inner = Group::new(group.delimiter(), replaced(group.stream(), values));
                filled.extend([TokenTree::from(inner)]);
            }
            (None, token) => filled.extend([token]),
        }
    }
    filled
}

/// Returns a name that does not occur in the code.
pub(crate) fn unused(name: &str, input: &TokenStream) -> String {
    let mut unused = name.to_owned();
    while any(input.clone(), &|token, _| token == unused) {
        unused.push('x');
    }
    unused
}

/// Whether `test` is true for any identifier in the code. `test` receives the identifier and the punctuation before it.
pub(crate) fn any(code: TokenStream, test: &impl Fn(&str, &str) -> bool) -> bool {
    let mut before = String::new();
    code.into_iter().any(|token| {
        let found = match &token {
            TokenTree::Ident(ident) => test(&ident.to_string(), &before),
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

/// Whether a token is this word.
pub(crate) fn is(token: &TokenTree, word: &str) -> bool {
    let TokenTree::Ident(ident) = token else {
        return false;
    };
    let text = ident.to_string();
    text == word
}

/// Whether a token is this character.
pub(crate) fn is_punct(token: &TokenTree, character: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == character)
}

/// Whether a token is a group with this delimiter.
pub(crate) fn is_group(token: &TokenTree, delimiter: Delimiter) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == delimiter)
}

/// Counts the angle brackets that are open, because the compiler does not group tokens by them. The `>` of an arrow closes
/// none.
#[derive(Default)]
pub(crate) struct Angles {
    pub(crate) depth: usize,
    arrow: bool,
}

impl Angles {
    /// Takes the next token, and returns the depth behind it.
    pub(crate) fn pass(&mut self, token: &TokenTree) -> usize {
        if is_punct(token, '<') {
            self.depth += 1;
        } else if is_punct(token, '>') && !self.arrow {
            self.depth = self.depth.saturating_sub(1);
        }
        self.arrow = is_punct(token, '-');
        self.depth
    }
}

/// Divides tokens at a character that is not in angle brackets. There is no empty last part.
pub(crate) fn parts(tokens: &[TokenTree], at: char) -> Vec<&[TokenTree]> {
    let (mut parts, mut begin, mut angles) = (Vec::new(), 0, Angles::default());
    for (place, token) in tokens.iter().enumerate() {
        if angles.pass(token) == 0 && is_punct(token, at) {
            parts.push(&tokens[begin..place]);
            begin = place + 1;
        }
    }
    if begin < tokens.len() {
        parts.push(&tokens[begin..]);
    }
    parts
}
