"""Checks of arguments that are whole numbers."""

from __future__ import annotations

import numbers
import operator
from typing import Any, Optional

from ._errors import InputError


def whole(name: str, value: Any, least: int, most: Optional[int] = None) -> int:
    """Converts an argument to a whole number from ``least`` to ``most``. A float such as 100.0 is one."""
    allowed = f"{least} or more" if most is None else f"{least} to {most}"
    try:
        given = int(value) if issubclass(type(value), numbers.Real) else operator.index(value)
        number = given if given == value else None
    except (TypeError, ValueError, OverflowError):
        number = None
    if number is None or number < least or (most is not None and number > most):
        raise InputError(f"{name}: {value!r}: expected a whole number, {allowed}")
    return number


def seed(value: Any) -> int:
    """Converts an argument to a seed of the library's random generator."""
    return whole("seed", value, 0, 2**64 - 1)
