"""Values of elementary functions at double-double arguments, by mpmath at 60 digits.

    python3 generate.py > mpmath.txt
"""
import random

from mpmath import atan2, cos, erf, erfc, exp, ln, loggamma, mp, mpf, nstr, psi, re, sin, sqrt, tan, tanh

mp.dps = 60
random.seed(1)


def floats(value, count):
    """Splits a value into floats, largest first. The remainder is below the rounding of the last float."""
    parts = []
    for _ in range(count):
        parts.append(float(value))
        value -= mpf(parts[-1])
    return parts


def argument(least, most):
    """Draws a double-double of either sign, with all orders of magnitude equally likely."""
    size = mpf(10) ** random.uniform(least, most) * (1 + mpf(random.random()) * mpf(2) ** -54)
    return size * random.choice([1, -1])


def line(name, function, a, b=mpf(0)):
    (a, b) = ([float(x), float(x - float(x))] for x in (a, b))
    value = function(mpf(a[0]) + mpf(a[1]), mpf(b[0]) + mpf(b[1]))
    numbers = a + b + floats(value, 3)
    print(name, *map(repr, numbers), nstr(value, 40))


print("# python3 generate.py > mpmath.txt")
print("# function, two arguments as pairs of floats, the value as a sum of three floats, the value")
for _ in range(16):
    a, b = argument(-8, 8), argument(-8, 8)
    line("add", lambda x, y: x + y, a, b)
    line("add", lambda x, y: x + y, a, -a * (1 + argument(-20, -1)))
    line("mul", lambda x, y: x * y, a, b)
    line("div", lambda x, y: x / y, a, b)
    line("sqrt", lambda x, _: sqrt(x), abs(argument(-200, 200)))
    line("exp", lambda x, _: exp(x), argument(-12, 2.8))
    line("ln", lambda x, _: ln(x), abs(argument(-200, 200)))
    line("ln", lambda x, _: ln(x), 1 + argument(-20, -0.5))
    line("sin", lambda x, _: sin(x), argument(-12, 2))
    line("cos", lambda x, _: cos(x), argument(-12, 2))
    line("tan", lambda x, _: tan(x), argument(-12, 0))
    line("tanh", lambda x, _: tanh(x), argument(-12, 1.5))
    line("atan2", atan2, a, b)
    line("atan2", atan2, argument(-1, 1), argument(-1, 1))
    line("powi", lambda x, n: x**n, argument(-2, 2), mpf(random.randint(-20, 20)))
    line("powf", lambda x, y: x**y, abs(argument(-2, 2)), argument(-2, 1))
for _ in range(16):
    line("erf", lambda x, _: erf(x), argument(-12, 0.8))
    line("erfc", lambda x, _: erfc(x), argument(-3, 1.2))
    for x in (abs(argument(-6, 6)), -abs(argument(-3, 1))):
        line("ln_gamma", lambda x, _: re(loggamma(x)), x)
        line("digamma", lambda x, _: psi(0, x), x)
        line("trigamma", lambda x, _: psi(1, x), x)
