"""What users give, and what their functions return, as arrays of 64-bit floats; or refused, with what was expected."""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Sequence
from typing import Any, Callable, Optional, Union

import numpy as np

from .errors import InputError
from .recording import Floats

__all__ = ["called", "floats", "is_pandas", "matrix", "of_joints", "read_only", "refuse_cells", "refuse_unaligned", "returned", "shape_of"]


def floats(what: str, given: Any, *, field: Optional[str], masked_is_nan: bool = False) -> Floats:
    """Numbers of any kind; a copy only where they are no 64-bit floats. Masked entries are NaN, or refused."""
    array = _array(what, given, field)
    if array.dtype.kind not in "fiu":
        raise InputError(f"{_first_of_no_number(what, array)}; expected numbers", field=field)
    if isinstance(array, np.ma.MaskedArray):
        if np.ma.is_masked(array) and not masked_is_nan:
            raise InputError(f"{what} has masked entries; expected a number in each", field=field)
        return np.asarray(np.ma.filled(array.astype(np.float64), np.nan))
    return np.asarray(array, dtype=np.float64)


def _array(what: str, given: Any, field: Optional[str]) -> Any:
    if is_pandas(given):
        return _of_pandas(given)
    # NumPy drops the masks of arrays in a list.
    masked = isinstance(given, (list, tuple)) and any(isinstance(part, np.ma.MaskedArray) for part in given)
    try:
        return np.ma.array(given) if masked else np.asanyarray(given)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} is no table of numbers; expected rows of one length ({error})", field=field) from None


def is_pandas(given: Any) -> bool:
    """Whether it is a DataFrame or a Series."""
    return hasattr(given, "to_numpy") and hasattr(getattr(given, "index", None), "equals")


def _of_pandas(given: Any) -> Any:
    """As an array. In pandas' own types of numbers ``<NA>`` is NaN."""
    dtypes = [given.dtype] if given.ndim == 1 else list(given.dtypes)
    if all(dtype.kind in "fiu" for dtype in dtypes) and not all(isinstance(dtype, np.dtype) for dtype in dtypes):
        return given.to_numpy(dtype=np.float64, na_value=np.nan)
    return given.to_numpy()


def _first_of_no_number(what: str, array: Any) -> str:
    """Which entry of a mixture is no number, else of what kind all are."""
    if array.dtype.kind == "O":
        for place in np.ndindex(array.shape):
            if not isinstance(array[place], numbers.Real):
                at = f"[{', '.join(map(str, place))}]" if place else ""
                return f"{what}{at} is {array[place]!r}"
    return f"{what} holds {array.dtype}"


def matrix(what: str, given: Any, joints: Sequence[str]) -> Floats:
    """A row each pose, a column each joint; a copy only where the numbers are no 64-bit floats."""
    if hasattr(given, "columns") and hasattr(given, "to_numpy"):
        names = [str(name) for name in given.columns]
        if sorted(names) != sorted(joints):
            told = f"the columns of {what} are {', '.join(names)}; expected the joints {', '.join(joints)}"
            raise InputError(told, field=what)
        chosen = given[list(joints)]
        given = chosen if is_pandas(chosen) else chosen.to_numpy()
    cells = floats(what, given, field=what, masked_is_nan=True)
    if cells.ndim == 1 and len(joints) == 1:
        cells = cells[:, np.newaxis]
    if cells.ndim != 2 or cells.shape[1] != len(joints):
        told = f"{what} is {shape_of(cells)}; expected a row each pose and a column each joint ({', '.join(joints)})"
        raise InputError(told, field=what)
    return cells


def of_joints(what: str, given: Any, joints: Sequence[str]) -> Union[float, list[float]]:
    """One number for all joints, or one for each: of a Series by the names of the joints, where these are its index."""
    if is_pandas(given) and given.ndim == 1:
        names = [str(name) for name in given.index]
        if sorted(names) == sorted(joints):
            given = given[list(joints)]
        elif names != [str(place) for place in range(len(joints))]:
            told = f"the index of {what} is {', '.join(names)}; expected the joints {', '.join(joints)}"
            raise InputError(told, field=what)
    values = floats(what, given, field=what)
    if values.ndim > 1:
        raise InputError(f"{what} is {shape_of(values)}; expected one number, or one each joint ({', '.join(joints)})", field=what)
    wrong = np.flatnonzero(~np.isfinite(values))
    if wrong.size:
        place = f"[{wrong[0]}]" if values.ndim else ""
        raise InputError(f"{what}{place} is {values.flat[wrong[0]]}; expected a finite number", field=what)
    plain: Union[float, list[float]] = values.tolist()
    return plain


def refuse_cells(what: str, cells: Floats, joints: Sequence[str], good: Any, expected: str) -> None:
    """Says where the first cell is that is not good."""
    if not good.all():
        row, column = np.argwhere(~good)[0]
        raise InputError(f"{what}[{row}, {column}] ({joints[column]}) is {cells[row, column]}; expected {expected}", field=what)


def refuse_unaligned(given: Iterable[tuple[str, str, Any]]) -> None:
    """Rows are paired by their order: where the indices of pandas differ, they would be paired otherwise. Each with name and field."""
    indexed = [(name, field, one.index) for name, field, one in given if is_pandas(one)]
    for name, field, index in indexed[1:]:
        first = indexed[0][0]
        if not index.equals(indexed[0][2]):
            told = (
                f"{name} and {first} have different indices, and rows are paired by their order: align them, "
                f"as by {name}.loc[{first}.index], or pass arrays (.to_numpy()) where their order is the same"
            )
            raise InputError(told, field=field)


def shape_of(array: Floats) -> str:
    return " × ".join(str(length) for length in array.shape) or "a single number"


def read_only(array: Floats) -> Floats:
    """The same array, into which nobody can write any more: functions of users are given no other."""
    array.setflags(write=False)
    return array


def called(what: str, function: Callable[..., Any], *arguments: Any, field: str) -> Any:
    """What a function of the user returns. What it raises is told with its name, but for an `ArithmeticError`: there is no value there."""
    try:
        return function(*arguments)
    except ArithmeticError:
        raise
    except InputError as error:
        raise InputError(f"{what}: {error}", field=field) from error
    except Exception as error:
        raise InputError(f"{what} raised {type(error).__name__}: {error}", field=field) from error


def returned(what: str, given: Any, *, field: str, for_differences: bool = False) -> Floats:
    """What a function of the user returned: a copy, as it may return the same array each time."""
    # By far the most common, and asked often.
    if type(given) is np.ndarray and given.dtype == np.float64:
        own: Floats = given.copy()
        return own
    if given is None:
        raise InputError(f"{what} returned None: is there no `return` in it?", field=field)
    values = floats(f"what {what} returned", given, field=field)
    if for_differences and getattr(given, "dtype", None) in (np.float32, np.float16):
        told = f"{what} returned {given.dtype}, which is too coarse for derivatives by differences: compute in float64"
        raise InputError(told, field=field)
    return np.array(values)
