"""Scenes from names, paths, texts and dictionaries."""

from __future__ import annotations

import json
import numbers
import os
from collections.abc import Mapping
from typing import Any, Union

from . import _core
from ._core import Scene
from ._errors import InputError

#: A built-in name, a path, TOML text, or a dictionary of settings in place of a scene's own.
SceneLike = Union[str, "os.PathLike[str]", Mapping[str, Any], Scene]


def as_scene(source: SceneLike) -> Scene:
    """The scene that a name, a path, a text or a dictionary stands for.

    A text with a line break or an equals sign is TOML. A dictionary has the settings of sections,
    nested or with dots, and may name another scene than the default under ``"scene"``:
    ``{"scene": "stability", "physics": {"friction": 0.6}, "schedule.iterations": 100}``.
    """
    if isinstance(source, Scene):
        return source
    if isinstance(source, Mapping):
        settings = dict(source)
        base = as_scene(settings.pop("scene", None) or _core.scenes()[0])
        return base.overridden(_toml(settings)) if settings else base
    if isinstance(source, str) and ("\n" in source or "=" in source):
        return Scene.parse(source)
    if isinstance(source, (str, os.PathLike)):
        return Scene.load(source)
    raise InputError(
        f"a scene is a name, a path, TOML text or a dictionary, not {type(source).__name__}"
    )


def _toml(settings: Mapping[str, Any]) -> str:
    """The TOML of a dictionary of settings."""
    sections: dict[str, dict[str, Any]] = {}
    for key, value in settings.items():
        if isinstance(value, Mapping):
            sections.setdefault(key, {}).update(value)
            continue
        section, dot, name = str(key).partition(".")
        if not dot:
            raise InputError(f"{key!r} is a section: give it a dictionary of its settings")
        sections.setdefault(section, {})[name] = value
    lines = []
    for section, of_section in sections.items():
        lines.append(f"[{section}]")
        lines += [f"{name} = {_value(value)}" for name, value in of_section.items()]
    return "\n".join(lines) + "\n"


def _value(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, (bool, str)) or type(value).__name__ == "bool_":
        return json.dumps(value if isinstance(value, str) else bool(value))
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, os.PathLike):
        return json.dumps(os.fspath(value))
    if hasattr(value, "tolist"):
        return _value(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_value, value)) + "]"
    raise InputError(f"{value!r} is no value of a scene: numbers, texts, truths and lists are")
