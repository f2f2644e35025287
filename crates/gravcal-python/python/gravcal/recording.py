"""Recordings of any kind, as arrays."""

from __future__ import annotations

import os
from dataclasses import dataclass
from os import PathLike
from typing import Any, Callable, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from .compared import Compared
from .errors import InputError, told_by_program

__all__ = ["Recording", "read"]

Path = Union[str, "PathLike[str]"]
Progress = Optional[Callable[[str], object]]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Recording(Compared):
    """Named columns of numbers, in the units of the file."""

    columns: tuple[str, ...]
    cells: Floats
    """A row each row of the recording, a column each column; NaN where a row says nothing."""
    remarks: tuple[str, ...]
    """What was lost or looks wrong."""

    def __len__(self) -> int:
        return len(self.cells)

    def __getitem__(self, column: str) -> Floats:
        try:
            place = self.columns.index(column)
        except ValueError:
            raise KeyError(f"there is no column `{column}`; the columns are {', '.join(self.columns)}") from None
        column_cells: Floats = self.cells[:, place]
        return column_cells

    def to_pandas(self) -> Any:
        """A DataFrame (needs pandas)."""
        import pandas

        return pandas.DataFrame(self.cells, columns=list(self.columns))


def read(path: Path, *, progress: Progress = None) -> Recording:
    """Reads a recording: CSV, MCAP, a bag of ROS 2 in SQLite or its folder, Parquet.

    Dates with times are seconds since 1970-01-01 in UTC. Raises `InputError`.
    """
    try:
        columns, cells, remarks = _native.read_recording(path, progress)
    except InputError as error:
        raise told_by_program(str(error), [os.fspath(path)]) from None
    return Recording(tuple(columns), cells, tuple(remarks))
