"""The exceptions of this package. Their messages are the library's own."""

from __future__ import annotations


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
