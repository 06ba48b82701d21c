//! `#[derive(Parameters)]`.

use crate::manifest::dependency;
use crate::structure::{Field, Kind, Parameter, Structure};
use crate::tokens::{Refusal, TokenStream as Code, TokenTree, code, filled, is, is_punct, parts};

/// Implements the trait for a struct.
pub(crate) fn implementation(input: Code) -> Result<Code, Refusal> {
    let refusal = "Parameters can only be derived for structs; enums and unions have no fixed number \
                   of parameters";
    let all = input.clone();
    let structure = Structure::read(input, refusal)?;
    let (number, root) = (number(&structure)?, root(&structure)?);
    let (other, walk) = (unused("Other", &all), unused("walk", &all));
    let mut body = Code::new();
    for field in &structure.fields {
        body.extend(copied(field, &number.to_string(), &walk));
    }
    let template = "
        impl<DECLARED> ROOT::Parameters<NUMBER> for NAME<OWN> CONDITIONS {
            type With<OTHER: ROOT::Real> = NAME<CHANGED>;
            fn map_numbers<OTHER: ROOT::Real>(
                &self,
                WALK: &mut ROOT::parameters::Walk<'_, NUMBER, OTHER>,
            ) -> NAME<CHANGED> {
                NAME { BODY }
            }
        }";
    let with = |of_number: &Code| {
        listed(&structure.parameters, |parameter| match parameter.kind {
            Kind::Type => of_number.clone(),
            _ => parameter.argument.clone(),
        })
    };
    Ok(filled(
        template,
        &[
            (
                "DECLARED",
                &listed(&structure.parameters, |parameter| {
                    declared(parameter, &root)
                }),
            ),
            ("ROOT", &root),
            ("NUMBER", &number),
            ("NAME", &TokenTree::from(structure.name.clone()).into()),
            ("OWN", &with(&number)),
            ("CHANGED", &with(&code(&other))),
            ("CONDITIONS", &structure.conditions),
            ("OTHER", &code(&other)),
            ("WALK", &code(&walk)),
            ("BODY", &body),
        ],
    ))
}

/// Returns the parameters of a struct, each as the code that a function returns, with commas.
fn listed(parameters: &[Parameter], of: impl Fn(&Parameter) -> Code) -> Code {
    let mut list = Code::new();
    for parameter in parameters {
        list.extend([of(parameter), code(",")]);
    }
    list
}

/// Returns the declaration of a parameter. The number type gets the bound `Real`.
fn declared(parameter: &Parameter, root: &Code) -> Code {
    let mut declared = parameter.declared.clone();
    if parameter.kind == Kind::Type {
        let tokens: Vec<TokenTree> = declared.clone().into_iter().collect();
        let before = match tokens.last() {
            _ if tokens.len() == 1 => ": ROOT::Real",
            Some(last) if is_punct(last, '+') || is_punct(last, ':') => "ROOT::Real",
            _ => "+ ROOT::Real",
        };
        declared.extend(filled(before, &[("ROOT", root)]));
    }
    declared
}

/// Returns the path of the crate `autodiff` in the user's code.
fn root(structure: &Structure) -> Result<Code, Refusal> {
    let mut root = None;
    for attribute in &structure.attributes {
        let [name, TokenTree::Group(group)] = &attribute[..] else {
            continue;
        };
        if !is(name, "autodiff") {
            continue;
        }
        let tokens: Vec<TokenTree> = group.stream().into_iter().collect();
        for entry in parts(&tokens, ',') {
            let path = match entry {
                [key, equals, TokenTree::Literal(path)]
                    if is(key, "crate") && is_punct(equals, '=') =>
                {
                    path.to_string()
                }
                _ => String::new(),
            };
            let path = path
                .strip_prefix('"')
                .and_then(|path| path.strip_suffix('"'));
            let Some(path) = path.and_then(|path| path.parse().ok()) else {
                let why = "unknown key; expected `crate = \"path\"`";
                let at = entry.first().map_or(group.span(), TokenTree::span);
                return Err(Refusal(at, why.into()));
            };
            root = Some(path);
        }
    }
    Ok(root.unwrap_or_else(|| {
        let name = dependency().unwrap_or_else(|| "autodiff".into());
        code(&format!("::{name}"))
    }))
}

/// Generates the expression that copies a field into the struct with the other number type.
fn copied(field: &Field, number: &str, walk: &str) -> Code {
    let member = &field.member;
    if mentions(&field.of, number) {
        let text = member.trim_start_matches("r#");
        code(&format!(
            "{member}: {walk}.field({text:?}, &self.{member}),"
        ))
    } else {
        code(&format!(
            "{member}: ::core::clone::Clone::clone(&self.{member}),"
        ))
    }
}

/// Returns the only type parameter of the struct.
fn number(structure: &Structure) -> Result<Code, Refusal> {
    let is_type = |parameter: &&Parameter| parameter.kind == Kind::Type;
    let types: Vec<&Parameter> = structure.parameters.iter().filter(is_type).collect();
    match &types[..] {
        [number] => Ok(number.argument.clone()),
        _ => Err(Refusal(
            structure.name.span(),
            format!(
                "Parameters needs a struct with one type parameter, the type of its numbers; `{}` has {}",
                structure.name,
                types.len()
            ),
        )),
    }
}

/// Returns a name that does not occur in the struct.
fn unused(name: &str, input: &Code) -> String {
    let mut unused = name.to_owned();
    while any(input.clone(), &|token, _| token == unused) {
        unused.push('x');
    }
    unused
}

/// Whether a type uses the number type. A lifetime or a part of a path with the same name does not count.
fn mentions(of: &Code, number: &str) -> bool {
    any(of.clone(), &|token, before| {
        token == number && !before.ends_with('\'') && !before.ends_with("::")
    })
}

/// Whether `test` is true for any identifier in the code. `test` receives the identifier and the punctuation before it.
fn any(code: Code, test: &impl Fn(&str, &str) -> bool) -> bool {
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

#[cfg(test)]
mod tests {
    use super::implementation;
    use crate::tokens::code;

    fn refused(input: &str) -> String {
        let found = implementation(code(input)).map(|code| code.to_string());
        found.map_err(|refusal| refusal.1).expect_err("a refusal")
    }

    /// Returns the implementation without spaces.
    fn derived(input: &str) -> String {
        let code = implementation(code(input)).map_err(|refusal| refusal.1);
        let code = code.expect("a struct with one type parameter").to_string();
        code.split_whitespace().collect()
    }

    #[test]
    fn an_attribute_names_the_crate() {
        let code = derived("#[autodiff(crate = \"outer::ad\")] struct Layer<R> { x: R }");
        assert!(
            code.starts_with("impl<R:outer::ad::Real,>outer::ad::Parameters<R>"),
            "{code}"
        );
        assert!(!code.contains("autodiff"), "{code}");
        let says = refused("#[autodiff(root = \"ad\")] struct Layer<R> { x: R }");
        assert!(says.contains("expected `crate"), "{says}");
    }

    #[test]
    fn all_parameters_are_repeated_without_defaults() {
        let input = "
            #[autodiff(crate = \"ad\")]
            pub(crate) struct Net<'a, 'b: 'a, R: Fn(f64) -> f64 = Id<f64>, const N: usize = { 1 + 1 }>
            where
                Of<{ N }>: Fn(f64),
            {
                #[doc = \"R\"]
                pub(in a::b) r#type: Vec<[R; N]>,
                pub map: HashMap<&'a str, other::R>,
            }";
        let code = derived(input);
        let head = "impl<'a,'b:'a,R:Fn(f64)->f64+ad::Real,constN:usize,>ad::Parameters<R>forNet<'a,'b,R,N,>whereOf<{N}>:Fn(f64),{";
        assert!(code.starts_with(head), "{code}");
        assert!(
            code.contains("typeWith<Other:ad::Real>=Net<'a,'b,Other,N,>;"),
            "{code}"
        );
        let body = "Net{r#type:walk.field(\"type\",&self.r#type),map:::core::clone::Clone::clone(&self.map),}";
        assert!(code.contains(body), "{code}");
        let code = derived(
            "struct Pair<R: Copy + 'static>(pub(crate) R, pub (u8, Other),) where R: Send;",
        );
        assert!(
            code.contains("<R:Copy+'static+::autodiff::Real,>"),
            "{code}"
        );
        assert!(
            code.contains("forPair<R,>whereR:Send{typeWith<Otherx:"),
            "{code}"
        );
        let body = "Pair{0:walk.field(\"0\",&self.0),1:::core::clone::Clone::clone(&self.1),}";
        assert!(code.contains(body), "{code}");
        assert!(derived("struct Unit<R>;").contains("Unit{}"));
    }

    #[test]
    fn a_struct_without_one_type_parameter_is_refused_by_name() {
        let says = "one type parameter, the type of its numbers; `Layer` has";
        let none = refused("struct Layer<'a, const N: usize> { x: &'a [f64; N] }");
        assert!(none.contains(&format!("{says} 0")), "{none}");
        assert!(refused("struct Layer { x: f64 }").contains(&format!("{says} 0")));
        let two = refused("struct Layer<R, T> { x: R, y: T }");
        assert!(two.contains(&format!("{says} 2")), "{two}");
        for input in [
            "enum Layer<R> { One(R), Two(R) }",
            "pub union Layer<R: Copy> { x: R }",
        ] {
            let says = refused(input);
            assert!(says.contains("derived for structs"), "{says}");
        }
    }
}
