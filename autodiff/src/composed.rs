//! Longer default methods of [`Real`](crate::Real), as macros: a file that the trait imports cannot know the trait.

/// Adds a slice of numbers: `Real::sum_of`. The additions of one sixteen do not wait for those of the next.
macro_rules! sum_of {
    ($terms:expr) => {{
        let (mut terms, mut few): (&[Self], usize) = ($terms, 128);
        let mut sums: Vec<Self>;
        // Loops, because closures might be compiled without the instruction set of the lanes.
        while terms.len() > few {
            let mut next = Vec::with_capacity(terms.len().div_ceil(16));
            for sixteen in terms.chunks(16) {
                let mut sum = Self::zero();
                for &term in sixteen {
                    sum += term;
                }
                next.push(sum);
            }
            sums = next;
            (terms, few) = (&sums, 16);
        }
        let mut sum = Self::zero();
        for &term in terms {
            sum += term;
        }
        sum
    }};
}

/// A sum over a slice: `$sum` returns the sum over `$few` of its numbers. Up to 128 numbers are summed at once. Of more,
/// the sums of sixteen are added by [`Real::sum_of`](crate::Real::sum_of).
macro_rules! by_parts {
    ($numbers:expr, |$few:ident| $sum:expr) => {{
        let numbers: &[Self] = $numbers;
        if numbers.len() <= 128 {
            let $few = numbers;
            $sum
        } else {
            let mut sums = Vec::with_capacity(numbers.len().div_ceil(16));
            for $few in numbers.chunks(16) {
                sums.push($sum);
            }
            Self::sum_of(&sums)
        }
    }};
}

/// The Euclidean length of a slice of numbers: `Real::norm`.
macro_rules! norm {
    ($x:expr) => {{
        let x: &[Self] = $x;
        let (zero, one) = (Self::zero(), Self::one());
        let mut largest = zero;
        for &x in x {
            largest = x.detach().abs().max(largest);
        }
        let ordinary = Self::lit(1e-15).less(largest) & largest.less(1e15);
        if Self::Mask::IS_SINGLE && ordinary.all() {
            return $crate::composed::by_parts!(x, |few| Self::dot(few, few)).sqrt();
        }
        let scaled = !ordinary & zero.less(largest) & largest.finite();
        let unit = Self::select(scaled, largest, one);
        // The inverse of a subnormal unit is infinite. That of a multiple is finite, and the squares do not underflow.
        let multiple = unit * Self::lit((1_u64 << 54) as f64);
        let unit = Self::select(unit.recip().finite(), unit, multiple);
        let sum = $crate::composed::by_parts!(x, |few| {
            let mut sum = zero;
            for &x in few {
                let x = x / unit;
                sum = x.fma(x, sum);
            }
            sum
        });
        let origin = sum.less_equal(zero);
        Self::select(origin, zero, Self::select(origin, one, sum).sqrt() * unit)
    }};
}

/// The logarithm of a sum of powers: `Real::logsumexp`.
macro_rules! logsumexp {
    ($x:expr) => {{
        let x: &[Self] = $x;
        let Some((&first, others)) = x.split_first() else {
            return Self::lit(f64::NEG_INFINITY);
        };
        let (zero, one) = (Self::zero(), Self::one());
        let mut top = first;
        for &x in others {
            top = Self::select(top.less(x), x, top);
        }
        // The sum of the powers is `e^top (1 + rest)`. The rest lacks the first term that is as large as `top`.
        let (held, mut found) = (top.detach(), Self::Mask::splat(false));
        let rest = $crate::composed::by_parts!(x, |few| {
            let mut rest = zero;
            for &x in few {
                let same = x.less_equal(held) & held.less_equal(x);
                let (first, endless) = (same & !found, !held.finite() & !x.finite());
                let ordered = x.less_equal(held) | held.less_equal(x);
                found = found | same;
                let skipped = first | (endless & ordered);
                if Self::Mask::IS_SINGLE && skipped.any() {
                    continue;
                }
                rest += Self::select(skipped, zero, (x - held).exp());
            }
            rest
        });
        // The powers of `top - held` are 1, and only move. In both forms no derivative is a small difference of large
        // numbers: that of the largest term is `1 - rest / (1 + rest)` if the rest is small, otherwise `1 / (1 + rest)`.
        let large = one.less(rest);
        let power = Self::select(large, top - held, held - top).exp();
        let more = Self::select(large, rest - one + power, rest * power).ln_1p();
        let value = Self::select(large, held, top) + more;
        Self::select(top.finite() | !rest.less_equal(rest), value, top)
    }};
}

/// Defines the method `ln_beta`.
macro_rules! ln_beta {
    () => {
        /// Returns the logarithm of the beta function of two positive numbers `a` and `b`, which is
        /// `ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b)`. That formula loses its digits if a number is large, and this
        /// method does not (A. R. DiDonato and A. H. Morris, "Algorithm 708", ACM Transactions on Mathematical Software
        /// 18, 1992). It is infinite if a number is 0, and NaN if one is negative.
        #[inline(always)]
        fn ln_beta<T>(self, b: T) -> Self
        where
            Self: Accepts<T>,
        {
            let (a, b, half) = (self, Self::accept(b), Self::lit(0.5));
            let first = a.less(b);
            let (p, q) = (Self::select(first, a, b), Self::select(first, b, a));
            let p = Self::select(p.less(0.0), p * Self::lit(f64::NAN), p);
            let (sum, far) = (p + q, Self::lit(16.0).less_equal(q));
            let of_p = p.ln_gamma();
            let near = of_p + (q.ln_gamma() - sum.ln_gamma());
            if Self::Mask::IS_SINGLE && !far.any() {
                return near;
            }
            // The distances of `ln_gamma` from Stirling's formula, for numbers of at least 16.
            let mut rests = [p, q, sum];
            for rest in &mut rests {
                let inverse = rest.recip();
                let (square, mut series) = (inverse * inverse, Self::zero());
                for k in (0..17).rev() {
                    let [numerator, denominator] = $crate::elementary::BERNOULLI[k];
                    let twice = 2.0 * (k + 1) as f64;
                    let denominator = Self::lit(denominator * twice * (twice - 1.0));
                    series = Self::lit(numerator) / denominator + series * square;
                }
                *rest = series * inverse;
            }
            let ([by_p, by_q, by_sum], share) = (rests, p / sum);
            let ln_rest = (-share).ln_1p();
            let ln_sqrt_2_pi = Self::lit(0.9189385332046728) + Self::lit(-3.8782941580672414e-17);
            let constant = by_p + (by_q - by_sum) + ln_sqrt_2_pi - half * q.ln();
            let both = constant + (p - half) * share.ln() + q * ln_rest;
            let one = of_p + (by_q - by_sum) + (p - p * sum.ln()) + (q - half) * ln_rest;
            let value = Self::select(Self::lit(16.0).less_equal(p), both, one);
            let value = Self::select(q.finite(), value, -q);
            Self::select(far, value, near)
        }
    };
}

pub(crate) use {by_parts, ln_beta, logsumexp, norm, sum_of};
