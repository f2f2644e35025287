"""Residuals of one's own: what else was observed of the arm, as vectorised functions, inside the joint problem and judged like torques."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Callable, Optional

import numpy as np

from .errors import InputError
from .estimation.differences import STEP, by_differences
from .models import SensorParameter
from .recording import Floats

__all__ = ["Observed", "ResidualModel"]

# Numbers of a frame in the table that the compiled part hands over: rotation, row by row, and origin; then their slopes by each joint.
_ROTATION, _FRAME = 9, 12


class Observed:
    """Where the arm is and what was read, with an entry each row; of joints and links only what the model names, else NaN."""

    __slots__ = ("_columns", "_frames", "coordinates", "gravity", "positions")

    def __init__(self, gravity: Floats, coordinates: Floats, positions: Floats, frames: Mapping[str, Floats], columns: Mapping[str, Floats]) -> None:
        self.gravity = gravity
        """In the base's frame, m/s²: three numbers for all rows."""
        self.coordinates = coordinates
        """True coordinates of all joints, rad or m, a column each."""
        self.positions = positions
        """Position readings of all joints, a column each."""
        self._frames, self._columns = frames, columns

    def column(self, name: str) -> Floats:
        """A column of the model's own."""
        return self._columns[name]

    def rotation(self, link: str) -> Floats:
        """Rotations of a link's frame in the base's: rows by 3 by 3."""
        turned: Floats = self._frames[link][:, :_ROTATION].reshape(-1, 3, 3)
        return turned

    def origin(self, link: str) -> Floats:
        """Origins of a link's frame in the base's, m: rows by 3."""
        origins: Floats = self._frames[link][:, _ROTATION:_FRAME]
        return origins

    def point(self, link: str, point: Any) -> Floats:
        """A point of a link, m in its frame, in the base's frame: rows by 3."""
        moved: Floats = self.origin(link) + self.rotation(link) @ np.asarray(point, dtype=np.float64)
        return moved

    def gravity_on(self, link: str) -> Floats:
        """Gravity in the frame of a link, m/s²: rows by 3. What a level there senses."""
        seen: Floats = np.einsum("nij,i->nj", self.rotation(link), self.gravity)
        return seen

    def __len__(self) -> int:
        return len(self.coordinates)

    def _moved(self, joint: int, by: Floats) -> Observed:
        """The same with a joint elsewhere: to the first order, as differences need it."""
        coordinates = self.coordinates.copy()
        coordinates[:, joint] += by
        frames = {link: self._with_frame(table, joint, by) for link, table in self._frames.items()}
        return Observed(self.gravity, coordinates, self.positions, frames, self._columns)

    @staticmethod
    def _with_frame(table: Floats, joint: int, by: Floats) -> Floats:
        slopes = table[:, _FRAME * (1 + joint) : _FRAME * (2 + joint)]
        moved: Floats = table[:, :_FRAME] + by[:, None] * slopes
        return moved

    def _under(self, gravity: Floats) -> Observed:
        return Observed(gravity, self.coordinates, self.positions, self._frames, self._columns)


@dataclass(frozen=True)
class ResidualModel:
    """What else was observed: rows of the joint problem, one for each pose in which all of its columns have a number.

        0 = function(x, observed) ± std

    `function` is called with the parameters `x`, an array in the order of `parameters`, and with `Observed`, and returns an array with an
    entry each row, prediction less reading. A session names it: ``residual=[{"kind": name, "columns": {"reading": "dial"}}]``; its
    parameters are called ``name.zero`` in results. Derivatives are central differences, all rows by one call.
    """

    name: str
    function: Callable[[Floats, Observed], Any]
    std: float
    """Standard deviation of each row, in its unit."""
    parameters: Sequence[SensorParameter] = ()
    columns: Sequence[str] = ()
    """What it calls its columns in the tables."""
    joints: Sequence[str] = ()
    """Joints whose coordinates it reads."""
    links: Sequence[str] = ()
    """Links whose frames it reads."""
    gravity: bool = False
    """Whether it reads gravity."""
    help: str = "a function in Python"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.std) and self.std > 0.0):
            raise InputError(f"residual `{self.name}` has the standard deviation {self.std}; expected a positive number", field="std")

    # What the compiled part reads, and calls.

    @property
    def sees_gravity(self) -> bool:
        return self.gravity

    def evaluate_rows(
        self, x: Floats, gravity: Floats, table: Floats, seen: Sequence[int], slopes: bool
    ) -> tuple[Floats, Optional[Floats], Optional[Floats], Optional[Floats]]:
        """Values and, where wanted, derivatives by parameters, gravity and coordinates. A row of the table: coordinates and position
        readings of all joints, columns, then frames of links, each with its slopes."""
        observed = self._observed(gravity, table)
        values = self._values(x, observed)
        if not slopes:
            return values, None, None, None
        scale = np.array([abs(own.nominal) or own.limit for own in self.parameters])
        by_parameter = by_differences(lambda x: self._values(x, observed), x, scale) if len(x) else np.zeros((len(values), 0))
        by_gravity = np.zeros((len(values), 3))
        if self.gravity:
            by_gravity = by_differences(lambda g: self._values(x, observed._under(g)), gravity, np.ones(3))
        by_coordinate = np.zeros(observed.coordinates.shape)
        for joint in seen:
            step = STEP * np.maximum(1.0, np.abs(observed.coordinates[:, joint]))
            ahead, behind = (self._values(x, observed._moved(joint, by)) for by in (step, -step))
            by_coordinate[:, joint] = (ahead - behind) / (2.0 * step)
        return values, by_parameter, by_gravity, by_coordinate

    def _observed(self, gravity: Floats, table: Floats) -> Observed:
        # coordinates, positions: n each; columns: c; links: 12 (1 + n) each.
        width = table.shape[1] - len(self.columns) - _FRAME * len(self.links)
        joints = width // (2 + _FRAME * len(self.links))
        first = 2 * joints + len(self.columns)
        columns = {name: table[:, 2 * joints + place] for place, name in enumerate(self.columns)}
        own = _FRAME * (1 + joints)
        frames = {link: table[:, first + place * own : first + (place + 1) * own] for place, link in enumerate(self.links)}
        return Observed(gravity, table[:, :joints], table[:, joints : 2 * joints], frames, columns)

    def _values(self, x: Floats, observed: Observed) -> Floats:
        try:
            values = np.asarray(self.function(x, observed), dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"the function of residual `{self.name}`: {error}", field=self.name) from error
        if values.shape != (len(observed),):
            told = f"the function of residual `{self.name}` gives shape {values.shape}; expected {(len(observed),)}, an entry each row"
            raise InputError(told, field=self.name)
        return values

    def __reduce__(self) -> Any:
        said = (self.name, self.function, self.std, tuple(self.parameters), tuple(self.columns), tuple(self.joints))
        return (ResidualModel, (*said, tuple(self.links), self.gravity, self.help))
