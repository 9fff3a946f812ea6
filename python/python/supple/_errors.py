"""What can go wrong, with the place and the cure."""

from __future__ import annotations

from typing import Optional


class Error(Exception):
    """Anything that supple says went wrong.

    path: the file at fault; field: the argument, key or array at fault, such as "recipe.handles[2].count" or
    "poses[3, 1]"; problem: what is wrong with it; cure: what to do, as far as it is known. Each may be None.
    """

    path: Optional[str]
    field: Optional[str]
    problem: Optional[str]
    cure: Optional[str]

    def __init__(
        self,
        message: str,
        *,
        path: Optional[str] = None,
        field: Optional[str] = None,
        problem: Optional[str] = None,
        cure: Optional[str] = None,
    ) -> None:
        super().__init__(message)
        self.path = path
        self.field = field
        self.problem = problem
        self.cure = cure

    def __reduce__(self):
        # So that it comes through a pool of processes whole.
        return (_made_again, (type(self), str(self), self.__dict__.copy()))


def _made_again(kind, message, details):
    error = kind(message)
    error.__dict__.update(details)
    return error


class InvalidError(Error, ValueError):
    """An argument that cannot be used."""


class FormatError(Error, ValueError):
    """A file that is not what its format demands."""


class FileError(Error, OSError):
    """A file that could not be read or written."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class MissingFileError(FileError, FileNotFoundError):
    """A file that is not there."""


class SolveError(Error, ArithmeticError):
    """A linear system that could not be solved."""


class NotFiniteError(Error, ArithmeticError):
    """A step whose result is not finite; the simulation keeps the state that it had."""


class GpuError(Error, RuntimeError):
    """The graphics device refused, is missing or was lost."""
