"""Checks of arguments."""

from __future__ import annotations

import numbers
import operator
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Optional

import numpy as np

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


def choice(name: str, value: Any, allowed: Sequence[Optional[str]]) -> None:
    """Checks an argument that is one of some strings."""
    if not isinstance(value, (str, type(None))) or value not in allowed:
        raise InputError(f"{name}: {value!r}: allowed: {', '.join(map(repr, allowed))}")


def yes(name: str, value: Any) -> bool:
    """Checks an argument that is True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{name}: {value!r}: expected True or False")
    return bool(value)


def real(name: str, value: Any, least: float, unit: str = "") -> float:
    """Converts an argument to a finite number of ``least`` or more."""
    try:
        number = float(value) if np.ndim(value) == 0 and not isinstance(value, (str, bytes)) else np.nan
    except (TypeError, ValueError):
        number = np.nan
    if not (np.isfinite(number) and number >= least):
        allowed = f", {least:g}{unit} or more" if np.isfinite(least) else ""
        raise InputError(f"{name}: {value!r}: expected a finite number{allowed}")
    return number


def path(name: str, value: Any) -> Path:
    """Converts an argument to a path."""
    try:
        return Path(value)
    except TypeError:
        raise InputError(f"{name}: {value!r}: expected a path") from None


def array(name: str, value: Any, of: Any = np) -> Any:
    """Converts an argument to an array of the module ``of``. Tensors of torch keep their history."""
    # Many versions of `torch.asarray` detach tensors, also the given one. `torch.as_tensor` warns about read-only memory.
    make = getattr(of, "as_tensor", of.asarray)
    if of is not np and isinstance(value, np.ndarray) and not value.flags.writeable:
        value = value.copy()
    try:
        return make(value)
    except (TypeError, ValueError, RuntimeError) as error:
        raise InputError(f"{name}: expected an array of numbers: {error}") from None


def floats(name: str, value: Any) -> Any:
    """Converts an argument to an array of numbers."""
    made = array(name, value)
    if made.dtype.kind not in "fiu":
        raise InputError(f"{name} is of type {made.dtype}: expected float32 or float64")
    return made
