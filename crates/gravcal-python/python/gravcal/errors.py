"""What can go wrong."""

from __future__ import annotations

import os
import re
from collections.abc import Collection
from typing import Any, Optional

__all__ = ["GravcalError", "InputError"]


class GravcalError(Exception):
    """Anything that gravcal refuses."""


class InputError(GravcalError, ValueError):
    """Something is wrong with what was given: a file, an array, a name.

    `file`, `line` (counted from 1) and `field` (such as ``load[1].mass_kg``) tell the place, each `None` where it is not known. The message
    tells them, too.
    """

    def __init__(
        self, message: str, *, file: Optional[str] = None, line: Optional[int] = None, field: Optional[str] = None
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.field = field

    def __reduce__(self) -> Any:
        return (_rebuilt, (type(self), str(self), self.file, self.line, self.field))


def _rebuilt(
    kind: type[InputError], message: str, file: Optional[str], line: Optional[int], field: Optional[str]
) -> InputError:
    return kind(message, file=file, line=line, field=field)


_PLACE = re.compile(r"(?P<file>[^\n]+?)(?::(?P<line>\d+))?: (?:(?P<field>[A-Za-z_]\w*(?:\.\w+|\[\d+\])*): )?")


def told_by_program(told: str, given: Collection[str]) -> InputError:
    """What the program says on its standard error, as an exception with its place; `given` are the paths that it was called with."""
    message = told.strip()
    message = message[len("error: ") :] if message.startswith("error: ") else message
    place = _PLACE.match(message)
    # Other messages have colons, too: a file is one that was named, or that is there.
    if place is None or not (place["file"] in given or os.path.isfile(place["file"])):
        return InputError(message)
    line = int(place["line"]) if place["line"] else None
    return InputError(message, file=place["file"], line=line, field=place["field"] if line else None)


def without_file(error: InputError, path: str, instead: str) -> InputError:
    """The same of a file that nobody knows, as it is gone: called otherwise."""
    told = str(error).replace(path, instead)
    return error if told == str(error) else InputError(told, line=error.line, field=error.field)
