//! Formulas in scene files, such as `0.2 * stiffness * max(length - rest_length, 0)`.

use autodiff::{Mask, Real};
use toml::Spanned;
use toml::de::DeValue;

use super::inputs::InputField;
use super::limits::Limits;
use super::value::{Filled, SettingValue, misfit, word};

/// The largest number of characters of a formula, and how deep its parentheses may be nested.
const MOST: usize = 1000;
const DEEPEST: usize = 50;

/// A formula of numbers that have names. It is evaluated with any number type, so it can be differentiated like code.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    text: String,
    /// The names of the numbers that the formula may contain.
    names: &'static [&'static str],
    /// The operations. Their operands are results of earlier operations; the last result is that of the formula.
    operations: Vec<Operation>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operation {
    Constant(f64),
    /// The number with this index in the list of names.
    Named(usize),
    Unary(Unary, usize),
    Binary(Binary, [usize; 2]),
    /// The third operand where the first is less than the second, otherwise the fourth. `true` also allows equality.
    Where(bool, [usize; 4]),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Unary {
    Neg,
    Abs,
    Sqrt,
    Exp,
    Log,
    Sin,
    Cos,
    Tanh,
    Power(i32),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Power,
    Min,
    Max,
}

const UNARY: [(&str, Unary); 7] = [
    ("abs", Unary::Abs),
    ("sqrt", Unary::Sqrt),
    ("exp", Unary::Exp),
    ("log", Unary::Log),
    ("sin", Unary::Sin),
    ("cos", Unary::Cos),
    ("tanh", Unary::Tanh),
];
const BINARY: [(&str, Binary); 2] = [("min", Binary::Min), ("max", Binary::Max)];

impl Operation {
    /// Computes the operation. `y` returns the result of an earlier operation, and `x` has the numbers with names.
    fn eval<R: Real>(self, y: impl Fn(usize) -> R, x: &[R]) -> R {
        match self {
            Self::Constant(value) => R::lit(value),
            Self::Named(index) => x[index],
            Self::Unary(function, a) => {
                let a = y(a);
                match function {
                    Unary::Neg => -a,
                    Unary::Abs => a.abs(),
                    Unary::Sqrt => a.sqrt(),
                    Unary::Exp => a.exp(),
                    Unary::Log => a.ln(),
                    Unary::Sin => a.sin(),
                    Unary::Cos => a.cos(),
                    Unary::Tanh => a.tanh(),
                    Unary::Power(exponent) => a.powi(exponent),
                }
            }
            Self::Binary(function, operands) => {
                let [a, b] = operands.map(y);
                match function {
                    Binary::Add => a + b,
                    Binary::Sub => a - b,
                    Binary::Mul => a * b,
                    Binary::Div => a / b,
                    Binary::Power => a.powf(b),
                    Binary::Min => a.min(b),
                    Binary::Max => a.max(b),
                }
            }
            Self::Where(or_equal, operands) => {
                let [a, b, value, other] = operands.map(y);
                let equal = R::Mask::splat(or_equal) & a.less_equal(b);
                R::select(a.less(b) | equal, value, other)
            }
        }
    }

    fn operands(&self) -> &[usize] {
        match self {
            Self::Constant(_) | Self::Named(_) => &[],
            Self::Unary(_, operand) => std::slice::from_ref(operand),
            Self::Binary(_, operands) => operands,
            Self::Where(_, operands) => operands,
        }
    }
}

impl Expression {
    /// The formula `0`, as the default of a setting whose formulas may contain these names.
    pub fn zero(names: &'static [&'static str]) -> Self {
        Self {
            text: "0".to_owned(),
            names,
            operations: vec![Operation::Constant(0.0)],
        }
    }

    /// Evaluates the formula. `x` has the numbers, in the order of their names.
    pub fn eval<R: Real>(&self, x: &[R]) -> R {
        let mut y: Vec<R> = Vec::with_capacity(self.operations.len());
        for operation in &self.operations {
            y.push(operation.eval(|k| y[k], x));
        }
        y.pop().unwrap_or_else(R::zero)
    }

    /// Replaces the formula.
    ///
    /// # Errors
    /// Names the error in the text and its column, as the middle part of a message.
    fn parse(&mut self, text: &str) -> Result<(), String> {
        if text.len() > MOST {
            return Err(format!("is longer than {MOST} characters:"));
        }
        let mut parser = Parser {
            text,
            at: 0,
            depth: 0,
            names: self.names,
            operations: Vec::new(),
        };
        let parsed = parser.sum().and_then(|_| match parser.next() {
            None => Ok(()),
            Some(_) => parser.fail("needs an operator or the end"),
        });
        parsed.map_err(|wrong| {
            let column = text[..wrong.at].chars().count() + 1;
            format!("{} at column {column}:", wrong.says)
        })?;
        self.operations = parser.operations;
        text.clone_into(&mut self.text);
        Ok(())
    }
}

/// An error in a formula, and the byte at which it is.
struct Wrong {
    at: usize,
    says: String,
}

type Parsed<T> = Result<T, Wrong>;

/// Reads a formula from left to right. Methods return the index of the operation that they have added.
struct Parser<'t> {
    text: &'t str,
    at: usize,
    depth: usize,
    names: &'static [&'static str],
    operations: Vec<Operation>,
}

impl Parser<'_> {
    fn fail<T>(&self, says: &str) -> Parsed<T> {
        let says = says.to_owned();
        Err(Wrong { at: self.at, says })
    }

    /// Skips blanks and returns the next character.
    fn next(&mut self) -> Option<char> {
        let rest = self.text[self.at..].trim_ascii_start();
        self.at = self.text.len() - rest.len();
        rest.chars().next()
    }

    /// Reads one of these signs, if it is next, and returns its index.
    fn sign(&mut self, signs: &[&str]) -> Option<usize> {
        self.next();
        let rest = &self.text[self.at..];
        let sign = signs.iter().position(|sign| rest.starts_with(sign))?;
        self.at += signs[sign].len();
        Some(sign)
    }

    fn expect(&mut self, sign: &str) -> Parsed<()> {
        match self.sign(&[sign]) {
            Some(_) => Ok(()),
            None => self.fail(&format!("needs `{sign}`")),
        }
    }

    /// Adds the operation that is written at the byte `at`. Operations on constants are computed.
    fn push(&mut self, mut operation: Operation, at: usize) -> Parsed<usize> {
        let constant = |&k: &usize| match self.operations[k] {
            Operation::Constant(value) => Some(value),
            _ => None,
        };
        let operands = operation.operands();
        let is_constant = operands.iter().all(|k| constant(k).is_some());
        if is_constant && !matches!(operation, Operation::Named(_)) {
            let value = operation.eval(|k| constant(&k).unwrap_or(f64::NAN), &[]);
            if !value.is_finite() {
                let says = format!("has the constant {value}, which is not a finite number,");
                return Err(Wrong { at, says });
            }
            operation = Operation::Constant(value);
        }
        self.operations.push(operation);
        Ok(self.operations.len() - 1)
    }

    /// Reads operands with operators of equal precedence between them.
    fn chain(
        &mut self,
        signs: [&str; 2],
        functions: [Binary; 2],
        operand: impl Fn(&mut Self) -> Parsed<usize>,
    ) -> Parsed<usize> {
        let mut left = operand(self)?;
        while let Some(sign) = self.sign(&signs) {
            let at = self.at - 1;
            let right = operand(self)?;
            left = self.push(Operation::Binary(functions[sign], [left, right]), at)?;
        }
        Ok(left)
    }

    fn sum(&mut self) -> Parsed<usize> {
        self.chain(["+", "-"], [Binary::Add, Binary::Sub], Self::product)
    }

    fn product(&mut self) -> Parsed<usize> {
        self.chain(["*", "/"], [Binary::Mul, Binary::Div], Self::signed)
    }

    /// Reads a power with signs before it. `-x^2` is the negative of the square.
    fn signed(&mut self) -> Parsed<usize> {
        if self.depth == DEEPEST {
            return self.fail(&format!("is nested more than {DEEPEST} times"));
        }
        self.depth += 1;
        let read = match self.sign(&["-", "+"]) {
            Some(0) => {
                let at = self.at - 1;
                let operand = self.signed();
                operand.and_then(|x| self.push(Operation::Unary(Unary::Neg, x), at))
            }
            Some(_) => self.signed(),
            None => self.power(),
        };
        self.depth -= 1;
        read
    }

    fn power(&mut self) -> Parsed<usize> {
        let base = self.operand()?;
        if self.sign(&["^", "**"]).is_none() {
            return Ok(base);
        }
        let at = self.at - 1;
        let exponent = self.signed()?;
        let whole = match self.operations[exponent] {
            Operation::Constant(n) if n == f64::from(n as i32) => Some(n as i32),
            _ => None,
        };
        let power = match whole {
            Some(n) => Operation::Unary(Unary::Power(n), base),
            None => Operation::Binary(Binary::Power, [base, exponent]),
        };
        self.push(power, at)
    }

    /// Reads a number, a name, a call or a formula in parentheses.
    fn operand(&mut self) -> Parsed<usize> {
        match self.next() {
            Some('0'..='9' | '.') => self.number(),
            Some('a'..='z' | 'A'..='Z' | '_') => self.name(),
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                self.expect(")")?;
                Ok(inner)
            }
            _ => self.fail("needs a number, a name or `(`"),
        }
    }

    /// The length of the text from here on whose characters, each with the one before it, pass a test.
    fn while_is(&self, is: impl Fn(u8, u8) -> bool) -> usize {
        let rest = &self.text.as_bytes()[self.at..];
        let before = std::iter::once(&b' ').chain(rest);
        let own = rest.iter().zip(before);
        own.take_while(|(own, before)| is(**own, **before)).count()
    }

    fn number(&mut self) -> Parsed<usize> {
        let len = self.while_is(|c, before| {
            let signs = b"+-".contains(&c) && b"eE".contains(&before);
            signs || c.is_ascii_alphanumeric() || c == b'.'
        });
        let (at, text) = (self.at, &self.text[self.at..][..len]);
        let Ok(value) = text.parse() else {
            return self.fail(&format!("has the malformed number `{text}`"));
        };
        self.at += len;
        self.push(Operation::Constant(value), at)
    }

    fn name(&mut self) -> Parsed<usize> {
        let len = self.while_is(|c, _| c.is_ascii_alphanumeric() || c == b'_');
        let (at, name) = (self.at, &self.text[self.at..][..len]);
        if let Some(index) = self.names.iter().position(|known| *known == name) {
            self.at += len;
            return self.push(Operation::Named(index), at);
        }
        let unary = UNARY.iter().find(|(known, _)| *known == name);
        let binary = BINARY.iter().find(|(known, _)| *known == name);
        if unary.is_none() && binary.is_none() && name != "where" {
            return self.fail(&format!("has the unknown name `{name}`"));
        }
        self.at += len;
        self.expect("(")?;
        let first = self.sum()?;
        let call = if let Some(&(_, function)) = unary {
            Operation::Unary(function, first)
        } else if let Some(&(_, function)) = binary {
            Operation::Binary(function, [first, self.argument()?])
        } else {
            let Some(sign) = self.sign(&["<=", "<", ">=", ">"]) else {
                return self.fail("needs a comparison with <, <=, > or >=");
            };
            let second = self.sum()?;
            let [a, b] = match sign {
                0 | 1 => [first, second],
                _ => [second, first],
            };
            let (value, other) = (self.argument()?, self.argument()?);
            Operation::Where(sign % 2 == 0, [a, b, value, other])
        };
        self.expect(")")?;
        self.push(call, at)
    }

    /// Reads a comma and the argument after it.
    fn argument(&mut self) -> Parsed<usize> {
        self.expect(",")?;
        self.sum()
    }
}

impl SettingValue for Expression {
    fn allowed(&self, _: &Limits) -> String {
        let functions = UNARY.iter().map(|(name, _)| *name);
        let functions = functions.chain(BINARY.iter().map(|(name, _)| *name));
        format!(
            "a formula of numbers and {}, with + - * / ^, {} and where(left < right, value, other)",
            self.names.join(", "),
            functions.collect::<Vec<_>>().join(", ")
        )
    }

    fn toml(&self) -> String {
        format!("{:?}", self.text)
    }

    fn json(&self) -> serde_json::Value {
        self.text.as_str().into()
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let text = word(value)?;
        self.parse(text).map_err(|says| misfit(value, &says))
    }
}

impl<N: Real> InputField<N, Expression> for Expression {
    fn of(&self, _: &mut &[N]) -> Expression {
        self.clone()
    }
}
