"""What can go wrong."""

from __future__ import annotations

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
