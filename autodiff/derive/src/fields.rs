//! `#[derive(Fields)]`.

use crate::manifest::root;
use crate::structure::Structure;
use crate::tokens::{Refusal, TokenStream as Code, TokenTree, code, filled};

/// The package that has the trait `Fields`.
pub(crate) const PACKAGE: &str = "cosmic-autodiff-programs";

/// Implements the trait for a struct.
pub(crate) fn implementation(input: Code) -> Result<Code, Refusal> {
    let structure = Structure::read(input, "Fields can only be derived for structs")?;
    let number = structure.number("Fields")?;
    let root = root(PACKAGE, &structure.attributes)?;
    let Some(first) = structure.fields.first() else {
        let why = format!(
            "Fields needs at least one field; `{}` has none",
            structure.name
        );
        return Err(Refusal(structure.name.span(), why));
    };
    let of = |template: &str, of: &Code| {
        filled(
            template,
            &[("OF", of), ("ROOT", &root), ("NUMBER", &number)],
        )
    };
    // Where a field begins is the sum of the fields before it.
    let (mut at, mut read, mut write) = (code("0"), Code::new(), Code::new());
    for field in &structure.fields {
        let member = &field.member;
        for (code, template) in [
            (
                &mut read,
                format!("{member}: <OF as ROOT::Fields<NUMBER>>::first_of(&numbers[AT..]),"),
            ),
            (
                &mut write,
                format!("<OF as ROOT::Fields<NUMBER>>::write(self.{member}, &mut numbers[AT..]);"),
            ),
        ] {
            code.extend(filled(
                &template,
                &[
                    ("OF", &field.of),
                    ("ROOT", &root),
                    ("NUMBER", &number),
                    ("AT", &at),
                ],
            ));
        }
        at.extend(of("+ <OF as ROOT::Fields<NUMBER>>::COUNT", &field.of));
    }
    let any = format!("<OF as ROOT::Fields<NUMBER>>::any(&self.{})", first.member);
    let template = "
        impl<DECLARED> ROOT::Fields<NUMBER> for NAME<OWN> CONDITIONS {
            const COUNT: usize = AT;
            #[inline(always)]
            fn first_of(numbers: &[NUMBER]) -> Self { NAME { READ } }
            #[inline(always)]
            fn write(self, numbers: &mut [NUMBER]) { WRITE }
            #[inline(always)]
            fn any(&self) -> NUMBER { ANY }
        }";
    Ok(filled(
        template,
        &[
            (
                "DECLARED",
                &structure.declared(&code("::core::marker::Copy")),
            ),
            ("ROOT", &root),
            ("NUMBER", &number),
            ("NAME", &TokenTree::from(structure.name.clone()).into()),
            ("OWN", &structure.with(&number)),
            ("CONDITIONS", &structure.conditions),
            ("AT", &at),
            ("READ", &read),
            ("WRITE", &write),
            ("ANY", &of(&any, &first.of)),
        ],
    ))
}

#[cfg(test)]
mod tests {
    use super::implementation;
    use crate::tokens::code;

    /// Returns the implementation, or the refusal, without spaces.
    fn derived(input: &str) -> String {
        let found = implementation(code(input)).map(|code| code.to_string());
        let found = found.unwrap_or_else(|refusal| refusal.1);
        found.split_whitespace().collect()
    }

    #[test]
    fn every_field_begins_after_those_before_it() {
        let code = derived(
            "#[autodiff(crate = \"ad\")]
            struct Edge<T, const D: usize> { pub(crate) d: Vector<T, D>, r#type: T }",
        );
        let head = "impl<T:::core::marker::Copy,constD:usize,>ad::Fields<T>forEdge<T,D,>{";
        assert!(code.starts_with(head), "{code}");
        let count = "=0+<Vector<T,D>asad::Fields<T>>::COUNT+<Tasad::Fields<T>>::COUNT;";
        assert!(code.contains(count), "{code}");
        let last = "r#type:<Tasad::Fields<T>>::first_of(&numbers[0+<Vector<T,D>asad::Fields<T>>::COUNT..]),";
        assert!(code.contains(last), "{code}");
        assert!(derived("struct Pair<T>(pub(crate) T, pub [T; 2]);").contains("<[T;2]as::"));
    }

    #[test]
    fn a_struct_without_numbers_is_refused() {
        assert!(derived("struct Unit<T>;").contains("atleastonefield"));
        assert!(derived("struct Fixed { x: f64 }").contains("onetypeparameter"));
        assert!(derived("enum Either<T> { A(T) }").contains("onlybederivedforstructs"));
    }
}
