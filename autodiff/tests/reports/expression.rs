//! The small language of the functions in `data/reports/reports.json`, which its README describes.

use crate::common::{Formula, Sym, Truth, formula};
use autodiff::Real;

/// Records a function of several numbers.
///
/// # Panics
/// If the text is not in the language.
pub(super) fn parsed(text: &str, arguments: usize) -> Formula {
    formula(arguments, |x| {
        let named = ["x", "y", "z", "w"].map(String::from).into_iter();
        let mut parser = Parser {
            rest: "",
            names: named.zip(x.iter().copied()).collect(),
        };
        let (definitions, result) = text.rsplit_once(';').unwrap_or(("", text));
        for definition in definitions.split_terminator(';') {
            let (name, value) = definition.split_once(" = ").expect("`name = value`");
            let value = parser.whole(value);
            parser.names.push((name.trim().into(), value));
        }
        parser.whole(result)
    })
}

struct Parser<'a> {
    rest: &'a str,
    names: Vec<(String, Sym)>,
}

impl<'a> Parser<'a> {
    fn whole(&mut self, text: &'a str) -> Sym {
        self.rest = text;
        let value = self.sum();
        assert_eq!(self.rest.trim(), "", "the end of {text}");
        value
    }

    /// Skips a symbol if it comes next.
    fn takes(&mut self, symbol: &str) -> bool {
        let rest = self.rest.trim_start().strip_prefix(symbol);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    #[track_caller]
    fn must_take(&mut self, symbol: &str) {
        assert!(self.takes(symbol), "{symbol} before {}", self.rest);
    }

    fn sum(&mut self) -> Sym {
        let mut sum = self.product();
        loop {
            if self.takes("+") {
                sum += self.product();
            } else if self.takes("-") {
                sum -= self.product();
            } else {
                return sum;
            }
        }
    }

    fn product(&mut self) -> Sym {
        let mut product = self.factor();
        loop {
            if self.takes("*") {
                product *= self.factor();
            } else if self.takes("/") {
                product /= self.factor();
            } else {
                return product;
            }
        }
    }

    fn factor(&mut self) -> Sym {
        if self.takes("-") {
            return -self.factor();
        }
        if self.takes("(") {
            let sum = self.sum();
            self.must_take(")");
            return sum;
        }
        let word = self.word();
        if let Ok(number) = word.parse() {
            return Sym::lit(number);
        }
        if self.takes("(") {
            let value = self.call(word);
            self.must_take(")");
            return value;
        }
        let named = self.names.iter().rev().find(|(name, _)| name == word);
        named.unwrap_or_else(|| panic!("no name {word}")).1
    }

    /// Takes a name or a number. A number may have a negative exponent.
    fn word(&mut self) -> &'a str {
        let text = self.rest.trim_start();
        let number = text.starts_with(|c: char| c.is_ascii_digit());
        let mut before = ' ';
        let ends = |c: char| {
            let exponent = number && c == '-' && before == 'e';
            before = c;
            !(c.is_alphanumeric() || c == '.' || exponent)
        };
        let (word, rest) = text.split_at(text.find(ends).unwrap_or(text.len()));
        self.rest = rest;
        word
    }

    fn call(&mut self, function: &str) -> Sym {
        if function == "where" {
            let mask = self.comparison();
            self.must_take(",");
            let if_true = self.sum();
            self.must_take(",");
            return Sym::select(mask, if_true, self.sum());
        }
        let first = self.sum();
        if function == "powi" {
            self.must_take(",");
            let sign = if self.takes("-") { -1 } else { 1 };
            let exponent: i32 = self.word().parse().expect("a whole exponent");
            return first.powi(sign * exponent);
        }
        let mut others = Vec::new();
        while self.takes(",") {
            others.push(self.sum());
        }
        match others[..] {
            [] => of_one(function, first),
            [second] => of_two(function, first, second),
            [low, high] if function == "clamp" => first.clamp(low, high),
            _ => panic!("no function {function} of {} numbers", others.len() + 1),
        }
    }

    fn comparison(&mut self) -> Truth {
        let left = self.sum();
        let compare = ["<=", ">=", "==", "<", ">"];
        let found = compare.into_iter().find(|symbol| self.takes(symbol));
        let right = self.sum();
        match found.expect("a comparison") {
            "<" => left.less(right),
            "<=" => left.less_equal(right),
            ">" => right.less(left),
            ">=" => right.less_equal(left),
            _ => left.less_equal(right) & right.less_equal(left),
        }
    }
}

fn of_one(function: &str, x: Sym) -> Sym {
    match function {
        "sqrt" => x.sqrt(),
        "cbrt" => x.cbrt(),
        "exp" => x.exp(),
        "expm1" => x.exp_m1(),
        "log" => x.ln(),
        "log1p" => x.ln_1p(),
        "sin" => x.sin(),
        "cos" => x.cos(),
        "tan" => x.tan(),
        "asin" => x.asin(),
        "acos" => x.acos(),
        "atan" => x.atan(),
        "sinh" => x.sinh(),
        "cosh" => x.cosh(),
        "tanh" => x.tanh(),
        "asinh" => x.asinh(),
        "acosh" => x.acosh(),
        "atanh" => x.atanh(),
        "abs" => x.abs(),
        "sign" => x.signum(),
        "sigmoid" => x.sigmoid(),
        "softplus" => x.softplus(),
        "sinc" => x.sinc(),
        "detach" => x.detach(),
        _ => panic!("no function {function} of one number"),
    }
}

fn of_two(function: &str, x: Sym, y: Sym) -> Sym {
    match function {
        "atan2" => x.atan2(y),
        "hypot" => x.hypot(y),
        "pow" => x.powf(y),
        "max" => x.max(y),
        "min" => x.min(y),
        _ => panic!("no function {function} of two numbers"),
    }
}
