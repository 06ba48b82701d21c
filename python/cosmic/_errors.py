"""The exceptions of this package. Their messages are the library's own."""

from __future__ import annotations

import re
import shlex


class Error(Exception):
    """Anything that goes wrong in this package."""


class InputError(Error, ValueError):
    """A scene, an array or another argument that is not as it should be."""


class FileError(Error, OSError):
    """A file or folder that is missing, unreadable, unwritable or in use."""


class DivergedError(Error, ArithmeticError):
    """A simulated state stopped being finite, or got where no robot gets."""


class UnstableStepError(Error, ArithmeticError):
    """A time step with which the robot's own vibrations grow."""


class InterruptedError(Error):
    """A run that was told to stop, and saved what resuming needs."""


class OutOfMemoryError(Error, MemoryError):
    """Results or a simulator that need more memory than there is. Nothing was begun."""


class InternalError(Error, RuntimeError):
    """A fault of the library itself, which should be reported."""


#: A command of the program with a folder or file, which a shell may need in quotes, and an option.
_COMMAND = re.compile(
    r"`?cosmic (?P<name>resume|evaluate)"
    r"(?P<path> (?!-)(?:'[^']*'|\\'|[^\s'`])+)?(?P<unstable> --allow-unstable)?`?"
)


def in_python(message: str) -> str:
    """A message of the library with the calls of this package in place of the program's commands."""
    message = re.sub(
        r"by record::resume_with, with its own loss, in (.*)$",
        lambda found: f"with: cosmic.resume({found[1]!r}, loss=...)",
        message,
        flags=re.MULTILINE,
    )
    return _COMMAND.sub(_call, message)


def _call(command: re.Match[str]) -> str:
    # A folder in a message may be followed by the end of the sentence.
    path = (command["path"] or "").strip()
    ends = re.search(r"[;.,)]*$", path)
    end = ends[0] if ends else ""
    try:
        [path] = shlex.split(path[: len(path) - len(end)])
    except ValueError:
        path = ""
    if command["name"] == "evaluate":
        return f"json.load(open({path!r}))" + end
    arguments = [repr(path) if path else "folder"]
    if command["unstable"]:
        arguments.append("allow_unstable=True")
    return f"cosmic.resume({', '.join(arguments)})" + end
