"""Adds the docs of attributes to ``help()``. They are strings after assignments, which editors show, but Python ignores."""

from __future__ import annotations

import ast
import inspect
import textwrap
from typing import Any, Optional


class _Docs:
    """The docs of a class with those of its attributes. The source is read only when somebody asks for the docs."""

    def __init__(self, plain: Optional[str]) -> None:
        self.plain = plain

    def __get__(self, _: Any, of: type) -> Optional[str]:
        try:
            attributes = _attributes(textwrap.dedent(inspect.getsource(of)))
        except OSError:
            return self.plain
        return f"{inspect.cleandoc(self.plain or '')}\n\nAttributes:\n\n" + "\n".join(attributes)


def _attributes(source: str) -> list[str]:
    """The attributes with docs, in the order of the source of a class."""
    [described] = ast.parse(source).body
    assert isinstance(described, ast.ClassDef)
    blocks = [described.body]
    blocks += [
        node.body for node in described.body if isinstance(node, ast.FunctionDef) and node.name == "__init__"
    ]
    found = []
    for block in blocks:
        for pair in zip(block, block[1:]):
            match pair:
                case (
                    ast.AnnAssign(target=target) | ast.Assign(targets=[target]),
                    ast.Expr(value=ast.Constant(value=str(text))),
                ):
                    name = ast.unparse(target).removeprefix("self.")
                    found.append(f"{name}\n{textwrap.indent(inspect.cleandoc(text), '    ')}\n")
    return found


def documented(*classes: type) -> None:
    """Adds the docs of attributes to the docs of classes."""
    for each in classes:
        setattr(each, "__doc__", _Docs(each.__doc__))
