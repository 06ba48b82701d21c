//! `#[derive(Parameters)]`.

use crate::manifest::root;
use crate::structure::{Field, Structure};
use crate::tokens::{Refusal, TokenStream as Code, TokenTree, any, code, filled, unused};

/// Implements the trait for a struct.
pub(crate) fn implementation(input: Code) -> Result<Code, Refusal> {
    let refusal = "Parameters can only be derived for structs; enums and unions have no fixed number \
                   of parameters";
    let all = input.clone();
    let structure = Structure::read(input, refusal)?;
    let number = structure.number("Parameters")?;
    let root = root("cosmic-autodiff", &structure.attributes)?;
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
    let bound = filled("ROOT::Real", &[("ROOT", &root)]);
    Ok(filled(
        template,
        &[
            ("DECLARED", &structure.declared(&bound)),
            ("ROOT", &root),
            ("NUMBER", &number),
            ("NAME", &TokenTree::from(structure.name.clone()).into()),
            ("OWN", &structure.with(&number)),
            ("CHANGED", &structure.with(&code(&other))),
            ("CONDITIONS", &structure.conditions),
            ("OTHER", &code(&other)),
            ("WALK", &code(&walk)),
            ("BODY", &body),
        ],
    ))
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

/// Whether a type uses the number type. A lifetime or a part of a path with the same name does not count.
fn mentions(of: &Code, number: &str) -> bool {
    any(of.clone(), &|token, before| {
        token == number && !before.ends_with('\'') && !before.ends_with("::")
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
