"""What a session is told, as a `session.toml` would say it."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from typing import Any, Optional

import numpy as np

from .errors import InputError

__all__ = ["as_arguments", "merged_readings", "plain", "refuse_unsayable"]

_BY_ARGUMENT = {"columns": "{}", "unit": "{}_unit", "std": "{}_std"}
"""Keys of a part of `readings` that an argument of `Session` says."""

_ARGUMENTS = (
    (re.compile(r"^readings\.(torque|position)\.(unit|std)\b"), r"\1_\2"),
    (re.compile(r"^poses\[\d+\]\.load\b"), "load"),
    (re.compile(r"^load\["), "loads["),
)
"""Fields of a `session.toml`, and what they are called among the arguments of `Session`."""


def merged_readings(given: Optional[Mapping[str, Any]], own: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """What is given of readings, with what other arguments say of positions and torques, key by key."""
    readings: dict[str, Any] = dict(_mapping("readings", given or {}))
    for part, said in own.items():
        further = _mapping(f"readings.{part}", readings.get(part) or {})
        arguments = {key: argument.format(part) for key, argument in _BY_ARGUMENT.items()}
        arguments.update({"std_columns": "torque_std"} if part == "torque" else {})
        twice = [key for key in further if key in arguments]
        if twice:
            field = f"readings.{part}.{twice[0]}"
            raise InputError(f"`{field}` is said by the argument `{arguments[twice[0]]}`: say it there", field=field)
        readings[part] = {**further, **said}
    return readings


def _mapping(field: str, given: Any) -> Mapping[str, Any]:
    if not isinstance(given, Mapping):
        raise InputError(f"{field} is {given!r}; expected a dictionary, as session.toml has a table there", field=field)
    return given


def plain(said: Any) -> Any:
    """The same of what JSON knows: arrays as lists, paths as text, without what is `None`."""
    if isinstance(said, Mapping):
        return {str(key): plain(value) for key, value in said.items() if value is not None}
    if isinstance(said, (np.ndarray, np.generic)):
        return said.tolist()
    if isinstance(said, os.PathLike):
        return os.fspath(said)
    if isinstance(said, (list, tuple)):
        return [plain(value) for value in said]
    return said


def refuse_unsayable(said: Any, field: str = "") -> None:
    """Says where something stands that is no finite number, text or truth."""
    if isinstance(said, dict):
        for key, value in said.items():
            refuse_unsayable(value, f"{field}.{key}" if field else key)
    elif isinstance(said, list):
        for place, value in enumerate(said):
            refuse_unsayable(value, f"{field}[{place}]")
    elif isinstance(said, float) and not math.isfinite(said):
        raise InputError(f"{field} is {said}; expected a finite number", field=field)
    elif not isinstance(said, (str, bool, int, float)):
        told = "None" if said is None else f"of type {type(said).__name__}"
        raise InputError(f"{field} is {told}; expected a number, text, a list or a dictionary", field=field)


def as_arguments(error: InputError) -> InputError:
    """The same error with the name that its field has among the arguments of `Session`."""
    for field, argument in _ARGUMENTS:
        renamed = field.sub(argument, error.field or "")
        if error.field and renamed != error.field:
            told = str(error).replace(error.field, renamed, 1)
            return InputError(told, file=error.file, line=error.line, field=renamed)
    return error
