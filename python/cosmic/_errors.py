"""The exceptions of this package. Their messages come from the library."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from contextlib import contextmanager


class Error(Exception):
    """The base class of all exceptions of this package."""


class InputError(Error, ValueError):
    """A scene, an array or another argument is invalid."""


class FileError(Error, OSError):
    """A file or folder is missing, unreadable, unwritable or in use."""


class DivergedError(Error, ArithmeticError):
    """A simulated state is not finite or impossibly far away."""


class UnstableStepError(Error, ArithmeticError):
    """The time step is unstable for the robot: its vibrations would grow."""


class InterruptedError(Error):
    """A run was stopped. It is saved and can be resumed."""


class OutOfMemoryError(Error, MemoryError):
    """Work needs more memory than the limit that :func:`cosmic.limit_memory` sets. Raised before it begins."""


class InternalError(Error, RuntimeError):
    """A bug in the library. Please report it."""


@contextmanager
def extra(name: str) -> Iterator[None]:
    """Surrounds the imports of packages that ``cosmic.name`` needs. If one is missing, the error says how to install it."""
    try:
        yield
    except ModuleNotFoundError as error:
        says = f"cosmic.{name} needs more packages ({error}): pip install 'cosmic-codesign[{name}]'"
        raise ImportError(says) from error


#: A command of the program, with a folder or file (possibly quoted for a shell) and options.
_COMMAND = re.compile(
    r"`?cosmic (?P<name>resume|evaluate|optimize)"
    r"(?P<path> (?!-)(?:'[^']*'|\\'|[^\s'`])+)?(?P<options>(?: --[a-z-]+(?: [A-Z]+)?)*)`?"
)


def in_python(message: str) -> str:
    """Replaces commands of the program in a message by calls of this package."""
    message = re.sub(
        r"with record::resume_with and the loss of the run in (.*)$",
        lambda found: f"with: cosmic.resume({found[1]!r}, loss=...)",
        message,
        flags=re.MULTILINE,
    )
    message = message.replace("`cosmic scene show SCENE` prints it", "cosmic.Scene.load(SCENE).to_toml() gives it")
    message = re.sub(
        r"cosmic sweep run ('[^']*'|\S+) --out DIR",
        lambda found: f"cosmic.sweep.run({' '.join(shlex.split(found[1]))!r}, DIR, index)",
        message,
    )
    return _COMMAND.sub(_call, message)


def _call(command: re.Match[str]) -> str:
    # Punctuation may follow a folder at the end of a sentence.
    path = (command["path"] or "").strip()
    ends = re.search(r"[;.,)]*$", path)
    end = ends[0] if ends else ""
    try:
        [path] = shlex.split(path[: len(path) - len(end)])
    except ValueError:
        path = ""
    if command["name"] == "evaluate":
        return f"json.load(open({path!r}))" + end
    name = command["name"]
    if not path and name == "optimize":
        return "cosmic.optimize" + end
    arguments = [repr(path) if path else "folder"]
    for option, value in re.findall(r" --([a-z-]+)(?: ([A-Z]+))?", command["options"]):
        arguments.append(f"{option.replace('-', '_')}={value or True}")
    return f"cosmic.{name}({', '.join(arguments)})" + end
