"""Checks the derivatives in reports.json against differences by mpmath, with steps of 1e-100 and 1e-130.

    python3 check.py [reports.json]

It uses no automatic differentiation. The entries of a case with `by` are not checked: they are a choice, such as the
derivative of the side that `where` takes, or a limit at infinity. The others must be the limits of differences from
the left and from the right: one number, or the interval between them.
"""
import ast
import json
import re
import struct
import sys
from pathlib import Path

import mpmath
from mpmath import mp, mpf

mp.dps = 900
STEPS = [mpf(10) ** -100, mpf(10) ** -130]
NAMES = "xyzw"


class Lazy(ast.NodeTransformer):
    """Makes `where` evaluate only the side that it takes."""

    def visit_Call(self, node):
        self.generic_visit(node)
        if node.func.id == "where":
            return ast.IfExp(*node.args)
        return node


def real(f):
    """Returns NaN where the function is complex."""
    def checked(*x):
        y = f(*x)
        return y if isinstance(y, mpf) else mpmath.nan
    return checked


FUNCTIONS = {name: real(getattr(mpmath, name)) for name in (
    "sqrt exp log sin cos tan tanh asin acos atan atan2 sinh cosh asinh acosh atanh cbrt sign hypot expm1 log1p"
).split()} | {
    "cbrt": lambda x: mpmath.sign(x) * mpmath.cbrt(abs(x)),
    "pow": real(lambda x, y: mpmath.power(x, y)),
    "powi": real(lambda x, n: mpmath.power(x, int(n))),
    "abs": abs, "max": max, "min": min, "detach": lambda x: x, "inf": mpmath.inf,
    "clamp": lambda x, lo, hi: min(max(x, lo), hi),
    "sigmoid": lambda x: 1 / (1 + mpmath.exp(-x)),
    "softplus": lambda x: mpmath.log1p(mpmath.exp(x)),
    "sinc": lambda x: mpmath.sin(x) / x if x else mpf(1),
}


def function(text):
    """Returns a function of a list of numbers."""
    *lets, result = [part.strip() for part in text.split(";")]
    number = re.compile(r"(?<![\w.])(\d+\.?\d*(e-?\d+)?)")
    code = "\n".join(lets + [f"result = {result}"])
    tree = ast.fix_missing_locations(Lazy().visit(ast.parse(number.sub(r"mpf(\1)", code))))
    compiled = compile(tree, text, "exec")

    def at(x):
        scope = dict(FUNCTIONS, mpf=mpf, **dict(zip(NAMES, x)))
        exec(compiled, scope)
        return scope["result"]
    return at


def limit(of_step):
    """Returns the limit as the step goes to zero, or None if the function is not defined there."""
    try:
        coarse, fine = map(of_step, STEPS)
    except ZeroDivisionError:
        return None
    if mpmath.isnan(fine) or mpmath.isnan(coarse):
        return None
    if abs(fine) < mpf(10) ** -330:  # below the smallest double: the rounding error of a zero
        return mpf(0)
    if abs(fine - coarse) <= abs(fine) * mpf(10) ** -40:
        return fine
    return mpf(0) if abs(fine) < abs(coarse) else fine * mpmath.inf


def sizes(x):
    """Returns the size of each number; for a zero, that of the smallest other number, at most 1."""
    least = min([mpf(1)] + [abs(number) for number in x if number])
    return [abs(number) or least for number in x]


def moved(x, *moves):
    """Returns the point with some numbers moved, each by a multiple of its size."""
    y, size = list(x), sizes(x)
    for i, by in moves:
        y[i] += by * size[i] if by else 0
    return y


def both(of_sign):
    """Returns the limits from the left and from the right where they exist, without repetition."""
    sides = [side for side in (limit(lambda h: of_sign(sign * h)) for sign in (-1, 1)) if side is not None]
    return [side for k, side in enumerate(sides) if not any(close(side, other) for other in sides[:k])]


def close(a, b):
    return a == b or mpmath.isfinite(a - b) and abs(a - b) <= mpf(10) ** -30 * max(abs(a), abs(b))


def value(f, x):
    """Returns the value, or its limit where the formula is not defined."""
    near = [[(i, sign * STEPS[1]) for i in range(len(x))] for sign in (0, -1, 1)]
    for moves in near:
        try:
            y = f(moved(x, *moves))
        except ZeroDivisionError:
            continue
        if not mpmath.isnan(y):
            # A limit of zero is not reached at any step.
            return y if moves is near[0] or abs(y) > mpf(10) ** -100 else mpf(0)


def gradient(f, x):
    """Returns a list of limits for each argument."""
    start, scale = value(f, x), sizes(x)
    return [both(lambda h: (f(moved(x, (i, h))) - start) / (h * scale[i])) for i in range(len(x))]


def hessian(f, x):
    """Returns a list of limits for each pair of arguments."""
    start, scale = value(f, x), sizes(x)

    def entry(i, j):
        def quotient(h):
            corners = f(moved(x, (i, h), (j, h))) - f(moved(x, (i, h))) - f(moved(x, (j, h))) + start
            return corners / (h * scale[i]) / (h * scale[j])
        return both(quotient)
    return [[entry(i, j) for j in range(len(x))] for i in range(len(x))]


def number(entry, single=False):
    """Returns a number of the file, which may be written as text: "inf", "-inf" or "nan"."""
    return mpf(struct.unpack("f", struct.pack("f", entry))[0] if single else entry)


def agrees(entry, limits):
    """Returns whether an entry of the file is the limit, or the interval between the limits."""
    bounds = sorted(limits)
    wanted = list(map(number, entry if isinstance(entry, list) else [entry]))
    # The file has doubles, and the smallest double is 2^-1074.
    near = (a == b or abs(a - b) <= mpf(2) ** -53 * max(abs(a), mpf(2) ** -1021) for a, b in zip(wanted, bounds))
    return len(bounds) == len(wanted) and all(near)


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent / "reports.json"
    cases, wrong = json.loads(Path(path).read_text())["cases"], 0
    for case in cases:
        if "by" in case:
            continue
        f = function(case["f"])
        x = [number(entry, single=case.get("type") == "f32") for entry in case["x"]]
        found = {"value": [[value(f, x)]], "gradient": gradient(f, x)}
        if "hessian" in case:
            found["hessian"] = sum(hessian(f, x), [])
        given = {"value": [case["value"]], "gradient": case["gradient"], "hessian": sum(case.get("hessian", []), [])}
        for what, limits in found.items():
            for entry, limit_ in zip(given[what], limits, strict=True):
                if not agrees(entry, limit_):
                    wrong += 1
                    print(case["f"], case["x"], what, entry, "not", [mpmath.nstr(y, 17) for y in limit_])
    print(f"{len(cases)} cases, {sum('by' not in case for case in cases)} checked, {wrong} entries wrong")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
