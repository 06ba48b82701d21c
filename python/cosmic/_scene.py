"""Makes scenes from names, paths, TOML texts and dictionaries."""

from __future__ import annotations

import json
import math
import numbers
import os
from collections.abc import Mapping
from typing import Any, Union

from . import _core
from ._core import Scene
from ._errors import InputError
from ._lattice import Lattice

#: A built-in name, a path, TOML text, or a dictionary of settings that change a scene.
SceneLike = Union[str, "os.PathLike[str]", Mapping[str, Any], Scene]


def as_scene(source: SceneLike) -> Scene:
    """Returns the scene of a name, a path, a TOML text or a dictionary.

    A string with a line break is TOML. A one-line string with an equals sign, such as
    ``"physics.friction = 0.6"``, is TOML too, unless a file has this name or the string ends with
    ``.toml``. (Folders of sweeps have equals signs in their names.) Any other string is a name or a
    path. A dictionary contains settings of sections, nested or with dots. They change the default
    scene, or the scene under the key ``"scene"``:
    ``{"scene": "stability", "physics": {"friction": 0.6}, "schedule.iterations": 100}``. Arrays are
    valid where lists are. Under the key ``"lattice"`` or ``"lattice.file"`` there may be a :class:`cosmic.Lattice`.
    """
    if isinstance(source, Scene):
        return source
    if isinstance(source, Mapping):
        settings = dict(source)
        if "base" in settings:
            raise InputError("`base` is not a key of a dictionary; name the base as `scene`")
        base = as_scene(settings.pop("scene", _core.scenes()[0]))
        settings, truss = _flat(settings), None
        for key in ("lattice", "lattice.file"):
            lattice = settings.get(key)
            if isinstance(lattice, Lattice):
                # The library knows the lattice by the name of the file that a run keeps of it.
                del settings[key]
                settings["lattice.file"], truss = "truss.json", lattice.truss
        return base.overridden(_toml(settings, base), truss) if settings else base
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


def _toml(settings: Mapping[str, Any], base: Scene) -> str:
    """Converts settings that change a scene, each with the key ``section.key``, to TOML."""
    sections: dict[str, list[str]] = {}
    for key, value in settings.items():
        section, dot, name = key.partition(".")
        if not dot:
            raise InputError(_no_section(key, base))
        sections.setdefault(section, []).append(f"{_key(name)} = {_value(key, value)}")
    lines = [line for section, own in sections.items() for line in (f"[{_key(section)}]", *own)]
    return "\n".join(lines) + "\n"


def _flat(settings: Mapping[Any, Any]) -> dict[str, Any]:
    """The settings, each with the key ``section.key``. Of equal keys, the last one counts."""
    flat: dict[str, Any] = {}
    for key, value in settings.items():
        if not isinstance(key, str):
            raise InputError(f"{key!r}: the key of a setting must be a string such as 'physics.steps'")
        if isinstance(value, Mapping):
            flat.update({f"{key}.{name}": own for name, own in value.items()})
        else:
            flat[key] = value
    return flat


def _no_section(key: str, base: Scene) -> str:
    """The message for a key without a section."""
    known = [path for path in base.keys() if path.endswith(f".{key}")]
    if any(path.startswith(f"{key}.") for path in base.keys()):
        return f"{key!r} is a section; it must be a dictionary of settings"
    write = " or ".join(map(repr, known)) or "'section.key'"
    return f"{key!r} is not a section of a scene; write a single setting as {write}"


def _key(name: str) -> str:
    """Converts a key to TOML, quoted if necessary, so that the library can read an unknown key and name it in its error."""
    is_bare = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if is_bare else json.dumps(_encodable(name))


def _value(key: str, value: Any) -> str:
    """Converts the value of a key to TOML."""
    if isinstance(value, str):
        # As in JSON, except for DEL and for characters above U+FFFF, which JSON writes as two escapes.
        return json.dumps(_encodable(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool) or type(value).__name__ in ("bool", "bool_"):
        return json.dumps(bool(value))
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return _number(key, float(value))
    if isinstance(value, os.PathLike):
        return _value(key, os.fsdecode(value))
    if hasattr(value, "tolist"):
        return _value(key, value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(key, entry) for entry in value) + "]"
    if isinstance(value, Lattice):
        raise InputError(f'`{key}` is {value!r}; a lattice has the key "lattice"')
    if value is None:
        raise InputError(
            f'`{key}` is None: leave the key out to keep the value of the scene, or write "off" to switch a setting off'
        )
    raise InputError(
        f"`{key}` is {value!r}, which is not a valid scene value; use a number, string, boolean or list"
    )


def _number(key: str, value: float) -> str:
    """Converts a number to TOML. A float without a fraction can be the value of a setting that is a whole number."""
    if not math.isfinite(value):
        raise InputError(f"`{key}` is {value}; it must be finite")
    if value.is_integer() and abs(value) < 2**53 and math.copysign(1.0, value) > 0.0:
        return str(int(value))
    return repr(value)


def _encodable(text: str) -> str:
    """Returns the text if it can be encoded. A path that is not UTF-8 contains lone surrogates."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise InputError(f"{text!r} is not valid text: a scene must be UTF-8") from None
    return text
