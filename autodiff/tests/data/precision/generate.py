"""Values, slopes and second derivatives over the whole range of f64, by mpmath at 2500 digits, for the gamma function at 800.

    python3 generate.py > mpmath.txt

Derivatives are central differences. Their steps are 1e-400 (1e-128) times the argument, so the truncation error is
below the rounding of f64. With 2500 (800) digits, the error from cancellation is too.
"""
from itertools import product

from mpmath import (acos, acosh, asin, asinh, atan, atan2, atanh, cbrt, cos, cosh, cospi, coth, erf, erfc, exp,
                    expm1, inf, ln, log1p, loggamma, mp, mpf, psi, re, sec, sin, sinh, sinpi, sqrt, tan, tanh)

mp.dps = 2500

SMALL = [5e-324, 1e-310, 1e-300, 1e-200, 1e-150, 1e-20, 1e-8]
MODERATE = [0.003, 0.3, 0.6, 1.0, 1.3, 2.5, 15.0, 25.0, 100.0, 360.0, 500.0, 700.0]
LARGE = [1e8, 1e20, 1e150, 1e300]
NEGATIVE = [-5e-324, -1e-310, -1e-20, -0.3, -1.0, -2.5, -15.0, -25.0, -500.0, -700.0, -1e20, -1e300]
POINTS = [0.0] + SMALL + MODERATE + LARGE + NEGATIVE
PAIRS = [
    (0.0, 1e-310), (5e-324, 0.0), (0.0, 5e-324), (5e-324, 5e-324), (1e-310, 1e-310), (1e-310, -3e-310),
    (1e-300, 1e-310), (1e-20, 1e-300), (3.0, -4.0), (-2.5, 0.7), (1.3, 2.5), (0.7, -0.3), (15.0, 25.0),
    (25.0, -15.0), (500.0, 700.0), (700.0, 500.0), (3e-8, 5e-8), (3e20, 1e20), (1e20, 1e-20), (1e-20, 1e20), (1e20, -3e20),
    (1e150, 1e150), (1e300, 1e300), (-1e300, 1e-300), (1e300, 0.7), (1e-310, 1e300), (0.7, 1e300),
]
NEAR_1 = [1 + 1e-9, 1 - 1e-9, -1 - 1e-9, 1.0001]


def rounded(number):
    """Returns the nearest float as text; zeros become +0."""
    return repr(float(number) + 0.0)


def steps(point):
    return [min(abs(mpf(x)) or 1, 1) * mpf(10) ** -(mp.dps * 4 // 25) for x in point]


def derivatives(f, point):
    """Returns the slopes, then the second derivatives, row by row from the diagonal on."""
    h, n = steps(point), len(point)

    def at(*moves):
        x = [mpf(x) for x in point]
        for i, sign in moves:
            x[i] += sign * h[i]
        return f(*x)

    def mixed(i, j):
        corners = product([1, -1], repeat=2)
        return sum(a * b * at((i, a), (j, b)) for a, b in corners) / (4 * h[i] * h[j])

    slopes = [(at((i, 1)) - at((i, -1))) / (2 * h[i]) for i in range(n)]
    second = [mixed(i, j) for i in range(n) for j in range(i, n)]
    return slopes + second


def line(name, f, point):
    numbers = [f(*map(mpf, point))] + derivatives(f, point)
    print(name, *map(repr, point), *map(rounded, numbers))


def one(name, f, low=-inf, high=inf, more=(), without=()):
    for x in sorted(POINTS + list(more)):
        if low <= x <= high and x not in without:
            line(name, f, (x,))


def two(name, f, among=lambda x, y: True):
    for point in filter(lambda point: among(*point), PAIRS):
        line(name, f, point)


def positive(x, y):
    return x > 0 and y > 0


def moderate(x, y):
    return all(1e-100 < abs(z) < 1e100 for z in (x, y)) and 1e-2 < abs(x / y) < 1e2


print("# python3 generate.py > mpmath.txt")
print("# function, arguments, value, slopes, second derivatives (xx, or xx xy yy)")

LEAST = 5e-324
ROOTS = {"low": LEAST}  # positive numbers

# Operations and methods.
one("neg", lambda x: -x)
one("square", lambda x: x * x)
one("cube", lambda x: x * x * x)
one("recip", lambda x: 1 / x, without=[0])
one("abs", abs, without=[0])
one("fma", lambda x: x * x + 3)
one("sqrt", sqrt, **ROOTS)
one("rsqrt", lambda x: 1 / sqrt(x), **ROOTS)
one("exp", exp, more=[709.7, 710.0, -745.0, -740.0])
one("ln", ln, **ROOTS)
one("sin", sin, more=[1e4, -9999.5])
one("cos", cos, more=[1e4, -9999.5])
one("tan", tan, more=[1e4, -9999.5])
one("tanh", tanh, more=[18.0, 19.1, 20.0, -360.0])
one("atan", atan)
one("clamp", lambda x: max(min(x, mpf(2)), mpf(-2)))
for exponent in (0, 1, 2, 3, 7, 100, -1, -2, -7, -100):
    name = f"powi_{exponent}".replace("-", "m")
    one(name, lambda x: x**exponent, without=[0] if exponent < 0 else [])
one("powi_1000", lambda x: x**1000, more=NEAR_1)
one("powi_m1000", lambda x: x**-1000, more=NEAR_1, without=[0])
one("powi_most", lambda x: x ** (2**31 - 1), more=NEAR_1)
one("powi_least", lambda x: x ** -(2**31), more=NEAR_1, without=[0])
one("powf_0.3", lambda x: x ** mpf(0.3), **ROOTS)
one("powf_1.5", lambda x: x ** mpf(1.5), **ROOTS)
one("powf_m2.5", lambda x: x ** mpf(-2.5), **ROOTS)
one("two_to_x", lambda x: mpf(2) ** x)
one("x_to_x", lambda x: x**x, low=1e-150)

# Elementary functions.
INSIDE = {"low": -1 + 1e-12, "high": 1 - 2**-53, "more": [0.5, 0.99, -0.99, 1 - 1e-10, 1 - 2**-53, -1 + 1e-10]}
one("asin", asin, **INSIDE)
one("acos", acos, **INSIDE)
one("sinh", sinh, more=[709.9, -710.3])
one("cosh", cosh, more=[709.9, -710.3])
one("asinh", asinh)
one("acosh", acosh, low=1 + 2**-52, more=[1 + 2**-52, 1 + 1e-10, 1.001])
one("atanh", atanh, **INSIDE)
one("exp_m1", expm1, more=[-36.0, -40.0, 709.7])
one("ln_1p", log1p, low=-1 + 2**-53, more=[-1 + 2**-53, -0.999, 1e-5, -1e-5], without=[-1])
one("log2", lambda x: ln(x) / ln(mpf(2)), **ROOTS)
one("log10", lambda x: ln(x) / ln(mpf(10)), **ROOTS)
one("cbrt", lambda x: cbrt(abs(x)) * (1 if x > 0 else -1), without=[0])
one("sigmoid", lambda x: 1 / (1 + exp(-x)), more=[-36.5, 36.5, 40.0])
one("softplus", lambda x: log1p(exp(x)), more=[-36.5, 36.5, 40.0])
one("log_sigmoid", lambda x: -log1p(exp(-x)), more=[-36.5, 36.5, 40.0])
one("xlogx", lambda x: x * ln(x), **ROOTS)

# Of two numbers.
two("add", lambda x, y: x + y)
two("sub", lambda x, y: x - y)
two("mul", lambda x, y: x * y)
two("div", lambda x, y: x / y, lambda x, y: y != 0)
two("max", max, lambda x, y: x != y)
two("min", min, lambda x, y: x != y)
two("dot", lambda x, y: x * y + y * x)
two("atan2", atan2)
two("hypot", lambda x, y: sqrt(x * x + y * y))
two("powf", lambda x, y: x**y, lambda x, y: x > 0)

# Formulas of one number. Within these ranges, all numbers in them and in their derivatives are finite, do not
# underflow to zero, and do not cancel completely.
TINY = [x for x in POINTS if 0 < abs(x) < 0.003]
MIDDLE = {"low": 1e-150, "high": 1e150}
one("logistic", lambda x: 1 / (1 + exp(-x)), low=-300, without=TINY)
one("softplus_by_halves", lambda x: log1p(exp(x)))
one("silu", lambda x: x / (1 + exp(-x)), low=-300)
one("fermi", lambda x: 1 / (1 + exp(x)), high=300, without=TINY)
one("ln_cosh", lambda x: ln(cosh(x)) if abs(x) < 5 else abs(x) + log1p(exp(-2 * abs(x))) - ln(mpf(2)), 0.3)
one("gaussian", lambda x: exp(-x * x), -25, 25)
one("maxwell", lambda x: x * x * exp(-x), -500, 700)
one("x_exp_minus_x", lambda x: x * exp(-x), -700, 700)
one("arrhenius", lambda x: exp(-1 / x), 0.003, 1e100)
one("pseudo_huber", lambda x: x * x / (1 + sqrt(1 + x * x)), -700, 700)
one("sqrt_1px2", lambda x: sqrt(1 + x * x), -700, 700)
one("rsqrt_1px2", lambda x: 1 / sqrt(1 + x * x), -1e50, 1e50)
one("ln_1p_x2", lambda x: log1p(x * x), -1e100, 1e100)
one("lorentz", lambda x: 1 / (1 + x * x), -1e50, 1e50)
one("softsign", lambda x: x / (1 + abs(x)), -700, 700, without=[0])
one("x_abs_x", lambda x: x * abs(x), without=[0])
one("sinc", lambda x: sin(x) / x if x else mpf(1))
one("sinhc", lambda x: sinh(x) / x if x else mpf(1), -700, 700)
one("tanhc", lambda x: tanh(x) / x, 0.3, 700)
one("exp_m1_over_x", lambda x: expm1(x) / x, 0.3, 700)
one("ln_1p_over_x", lambda x: log1p(x) / x, 0.3, 1e100)
one("x_ln_x", lambda x: x * ln(x), **MIDDLE)
one("ln_squared", lambda x: ln(x) ** 2, **MIDDLE)
one("entropy", lambda x: -x * ln(x) - (1 - x) * log1p(-x), 1e-150, 0.6)
one("logit", lambda x: ln(x) - log1p(-x), 1e-150, 0.6)
one("versine", lambda x: 2 * sin(x / 2) ** 2)
one("one_minus_cos", lambda x: 1 - cos(x), 0.6, 700)
one("cosh_m1", lambda x: 2 * sinh(x / 2) ** 2, -700, 700)
one("sin_cos", lambda x: sin(x) * cos(x))
one("sin_squared", lambda x: sin(x) ** 2)
one("sin_of_square", lambda x: sin(x * x), -25, 25)
one("exp_of_sin", lambda x: exp(sin(x)))
one("coth", coth, 0.003, 300)
one("sech", lambda x: 1 / cosh(x), -300, 300)
one("sec", sec)
one("gudermann", lambda x: 2 * atan(tanh(x / 2)), -300, 300)
one("ln_of_ln", lambda x: ln(ln(x)), 2, 1e150)
one("sqrt_ln", lambda x: sqrt(x) * ln(x), **MIDDLE)
one("root_difference", lambda x: 1 / (sqrt(x + 1) + sqrt(x)), 1e-150, 1e100)
one("cbrt_squared", lambda x: cbrt(x) ** 2, **MIDDLE)
one("horner", lambda x: ((x + 2) * x + 3) * x + 4, 0, 1e50)
one("rational", lambda x: (x * x + 1) / (x * x + 3), -700, 700)
one("lennard_jones", lambda x: x**-12 - x**-6, 0.6, 1e8, without=[1.0])
one("morse", lambda x: expm1(-(x - 1)) ** 2, 1.3, 300)
one("planck", lambda x: x**3 / expm1(x), 0.3, 300)
one("gelu", lambda x: x / 2 * (1 + tanh(mpf(0.75) * (x + x**3 / 32))), 0, 1e50)
one("x_to_minus_x", lambda x: x ** (-x), **MIDDLE)

# Formulas of two numbers.
two("ln_sum_exp", lambda x, y: ln(exp(x) + exp(y)), lambda x, y: 0.1 < abs(x - y) < 1e3 and abs(x) < 1e3)
two("softmax", lambda x, y: 1 / (1 + exp(y - x)), lambda x, y: 0.1 < abs(x - y) < 300 and abs(x) < 1e3)
two("parallel", lambda x, y: x * y / (x + y), lambda x, y: positive(x, y) and moderate(x, y))
two("contrast", lambda x, y: (x - y) / (x + y), lambda x, y: positive(x, y) and moderate(x, y))
two("geometric", lambda x, y: sqrt(x * y), lambda x, y: positive(x, y) and moderate(x, y))
two("decay", lambda x, y: x * exp(-y), lambda x, y: abs(y) < 710)
two("divergence", lambda x, y: x * ln(x / y), lambda x, y: positive(x, y) and moderate(x, y))
two("cosine_of_angle", lambda x, y: x / sqrt(x * x + y * y), moderate)
two("potential", lambda x, y: 1 / sqrt(x * x + y * y), moderate)
two("gravity", lambda x, y: x / sqrt(x * x + y * y) ** 3, moderate)
two("wave", lambda x, y: sin(x) * cos(y))
two("polar", lambda x, y: x * cos(y))
two("quotient_of_logs", lambda x, y: ln(x) / ln(y), lambda x, y: positive(x, y) and 1e-30 < y < 1e30 and 1e-100 < x)
two("boltzmann", lambda x, y: exp(-x / y), lambda x, y: 0.1 < abs(y) < 1e100 and abs(x) < 1e3)
two("elastic", lambda x, y: y / 2 * (sqrt(x * x + 1) - 1) ** 2, lambda x, y: 0.5 < abs(x) < 1e3)

# Special functions. Below 0 the gamma function is computed between its poles. The points are also near its zeros at 1,
# 1.4616… and 2. Fewer digits are enough for it, and take less time.
ERROR = {"low": -30, "high": 27, "more": [-5.5, 1e-3, 1.5, 3.7, 5.9, 26.1]}
one("erf", erf, **ERROR)
one("erfc", erfc, **ERROR)
one("ln_erfc", lambda x: ln(erfc(x)), -30, 1e8, more=[-5.5, 0.499, 0.501, 1.7, 2.99, 3.01, 5.9, 26.1, 30.0])
two("xlogy", lambda x, y: x * ln(y), lambda x, y: 1e-300 < y < 1e300)
two("norm", lambda x, y: sqrt(x * x + y * y), moderate)
two("logsumexp", lambda x, y: ln(exp(x) + exp(y)), lambda x, y: 1e-9 < abs(x) < 1e3 and abs(y) < 1e3)
mp.dps = 800
GAMMA = {"low": -40, "high": 1e20, "more": [-0.7, -1.3, -29.25, 0.999, 1.01, 1.46, 1.999, 7.5, 9.99, 10.1, 15.99]}
POLES = [0.0, -1.0, -15.0, -25.0]
one("ln_gamma", lambda x: re(loggamma(x)), without=POLES, **GAMMA)
# The zeros of the digamma function between its poles, as far as a float can be close to them.
ZEROS = [
    -0.5, -0.5040830082644554, -0.504083, -1.5734984731623904, -1.5734984, -2.6107208684441447, -3.635293366436901,
    -9.702672540001863, -11.714133061228955, -11.7141,
]
one("digamma", lambda x: psi(0, x), without=POLES, low=-40, high=1e20, more=GAMMA["more"] + ZEROS)
one("trigamma", lambda x: psi(1, x), without=POLES, **GAMMA)
two("ln_beta", lambda x, y: loggamma(x) + loggamma(y) - loggamma(x + y), lambda x, y: 1e-100 < min(x, y) and max(x, y) < 1e100)
one("cot_pi", lambda x: cospi(x) / sinpi(x), -40, 14, more=[-29.75, 0.26, 3.4999999], without=POLES + [1.0])
