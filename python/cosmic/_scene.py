"""Makes scenes from names, paths, TOML texts and dictionaries."""

from __future__ import annotations

import json
import numbers
import os
from collections.abc import Mapping
from typing import Any, Union

from . import _core
from ._core import Scene
from ._errors import InputError

#: A built-in name, a path, TOML text, or a dictionary of settings that change a scene.
SceneLike = Union[str, "os.PathLike[str]", Mapping[str, Any], Scene]


def as_scene(source: SceneLike) -> Scene:
    """Returns the scene of a name, a path, a TOML text or a dictionary.

    A string with a line break is TOML. A one-line string with an equals sign, such as
    ``"physics.friction = 0.6"``, is TOML too, unless a file has this name or the string ends with
    ``.toml``. (Folders of sweeps have equals signs in their names.) Any other string is a name or a
    path. A dictionary contains settings of sections, nested or with dots. They change the default
    scene, or the scene under the key ``"scene"``:
    ``{"scene": "stability", "physics": {"friction": 0.6}, "schedule.iterations": 100}``.
    """
    if isinstance(source, Scene):
        return source
    if isinstance(source, Mapping):
        settings = dict(source)
        if "base" in settings:
            raise InputError("`base` is not a key of a dictionary; name the base as `scene`")
        base = as_scene(settings.pop("scene", None) or _core.scenes()[0])
        return base.overridden(_toml(settings)) if settings else base
    if isinstance(source, str) and _is_toml(source):
        return Scene.parse(_encodable(source))
    if isinstance(source, (str, os.PathLike)):
        return Scene.load(source)
    raise InputError(
        f"a scene is a name, a path, TOML text or a dictionary, not {type(source).__name__}"
    )


def _is_toml(text: str) -> bool:
    """Whether a string is the TOML text of a scene and not a name or a path."""
    if "\n" in text:
        return True
    return "=" in text and not text.endswith(".toml") and not os.path.exists(text)


def _toml(settings: Mapping[str, Any]) -> str:
    """Converts a dictionary of settings to TOML."""
    sections: dict[str, dict[str, Any]] = {}
    for key, value in settings.items():
        if isinstance(value, Mapping):
            sections.setdefault(key, {}).update(value)
            continue
        section, dot, name = str(key).partition(".")
        if not dot:
            raise InputError(
                f"{key!r} must be a section with a dictionary of settings; write a single setting as "
                "'section.key'"
            )
        sections.setdefault(section, {})[name] = value
    lines = []
    for section, of_section in sections.items():
        lines.append(f"[{section}]")
        lines += [f"{name} = {_value(value)}" for name, value in of_section.items()]
    return "\n".join(lines) + "\n"


def _value(value: Any) -> str:
    """Converts a value to TOML."""
    if isinstance(value, str):
        # As in JSON, except for DEL and for characters above U+FFFF, which JSON writes as two escapes.
        return json.dumps(_encodable(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool) or type(value).__name__ in ("bool", "bool_"):
        return json.dumps(bool(value))
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, os.PathLike):
        return _value(os.fsdecode(value))
    if hasattr(value, "tolist"):
        return _value(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_value, value)) + "]"
    raise InputError(
        f"{value!r} is not a valid scene value; use a number, string, boolean or list"
    )


def _encodable(text: str) -> str:
    """Returns the text if it can be encoded. A path that is not UTF-8 contains lone surrogates."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise InputError(f"{text!r} is not valid text: a scene must be UTF-8") from None
    return text
