"""Derivatives by central differences, and the check of those that are given."""

from __future__ import annotations

from typing import Callable, Optional

import numpy as np

from ..arrays import read_only
from ..recording import Floats

__all__ = ["STEP", "by_differences", "mismatch"]

STEP = float(np.finfo(np.float64).eps) ** (1 / 3)
"""Balances the error of the difference, of second order, and that of rounding."""
_TOLERANCE = 1e-5
"""Share of the largest derivative of a column by which differences may be off."""


def by_differences(function: Callable[[Floats], Floats], x: Floats, scale: Floats) -> Floats:
    """Derivatives of `function` by each entry of `x`, rows by x: two calls a column, at steps of about 6e-6 of `|x|` or its scale.

    Each call must return an array of its own.
    """
    columns = []
    for place in range(len(x)):
        step = STEP * max(abs(x[place]), scale[place])
        ahead, behind = x.copy(), x.copy()
        ahead[place] += step
        behind[place] -= step
        # What was added, to the last bit.
        width = ahead[place] - behind[place]
        columns.append((function(read_only(ahead)) - function(read_only(behind))) / width)
    return np.column_stack(columns)


def mismatch(given: Floats, found: Floats, scale: Floats) -> Optional[tuple[int, int]]:
    """Row and column of the derivative that is furthest from differences, where one is."""
    # In what the residual changes by along each column; a column of zeros is compared with the largest of all.
    sizes = np.abs(found).max(axis=0) * scale
    allowed = _TOLERANCE * np.maximum(sizes, 1e-3 * sizes.max(initial=0.0)) + np.finfo(np.float64).tiny
    excess = np.abs(given - found) * scale / allowed
    excess[np.isnan(excess)] = np.inf
    row, column = np.unravel_index(int(np.argmax(excess)), excess.shape)
    return (int(row), int(column)) if excess[row, column] > 1.0 else None
