"""Residuals of one's own: what else was observed of the arm, as vectorised functions, inside the joint problem and judged like torques."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import Any, Callable, Optional

import numpy as np

from .arrays import called, read_only, returned
from .errors import InputError
from .estimation.differences import STEP, by_differences
from .models import ANY_NUMBER, SensorParameter, names, parameters_of
from .recording import Floats

__all__ = ["Observed", "ResidualModel"]

# Numbers of a frame in the table that the compiled part hands over: rotation, row by row, and origin; then their slopes by each joint.
_ROTATION, _FRAME = 9, 12


class Observed:
    """Where the arm is and what was read, with an entry each row; only of what the model names. It cannot be written into."""

    __slots__ = ("_columns", "_frames", "_gravity", "coordinates", "positions")

    def __init__(
        self, gravity: Optional[Floats], coordinates: Floats, positions: Floats, frames: Mapping[str, Floats], columns: Mapping[str, Floats]
    ) -> None:
        self._gravity = gravity
        self.coordinates = coordinates
        """True coordinates of all joints, rad or m, a column each; NaN of those that neither `joints` nor `links` need."""
        self.positions = positions
        """Position readings of all joints, a column each."""
        self._frames, self._columns = frames, columns

    @property
    def gravity(self) -> Floats:
        """In the base's frame, m/s²: three numbers for all rows."""
        if self._gravity is None:
            raise InputError("gravity is read, but the model does not say so: say gravity=True", field="gravity")
        return self._gravity

    def column(self, name: str) -> Floats:
        """A column of the model's own."""
        return _named("columns", self._columns, name)

    def rotation(self, link: str) -> Floats:
        """Rotations of a link's frame in the base's: rows by 3 by 3."""
        turned: Floats = _named("links", self._frames, link)[:, :_ROTATION].reshape(-1, 3, 3)
        return turned

    def origin(self, link: str) -> Floats:
        """Origins of a link's frame in the base's, m: rows by 3."""
        origins: Floats = _named("links", self._frames, link)[:, _ROTATION:_FRAME]
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
        return Observed(self._gravity, read_only(coordinates), self.positions, frames, self._columns)

    @staticmethod
    def _with_frame(table: Floats, joint: int, by: Floats) -> Floats:
        slopes = table[:, _FRAME * (1 + joint) : _FRAME * (2 + joint)]
        return read_only(table[:, :_FRAME] + by[:, None] * slopes)

    def _under(self, gravity: Floats) -> Observed:
        return Observed(gravity, self.coordinates, self.positions, self._frames, self._columns)


def _named(what: str, known: Mapping[str, Floats], name: str) -> Floats:
    if name not in known:
        told = f"`{name}` is read, but `{what}` of the model names {', '.join(known) or 'none'}: say {what}=[..., \"{name}\"]"
        raise InputError(told, field=what)
    return known[name]


@dataclass(frozen=True)
class ResidualModel:
    """What else was observed: rows of the joint problem, one for each pose in which all of its columns have a number.

        0 = function(x, observed) ± std

    `function` is called with the parameters `x`, an array in the order of `parameters`, and with `Observed`, and returns an array with an
    entry each row, however many there are, prediction less reading. It cannot write into what it is given. A
    session names it: ``residual=[{"kind": name, "columns": {"reading": "dial"}}]``; its parameters are called ``name.zero`` in results.
    Derivatives are central differences, all rows by one call.

    What a function raises ends the work with an `InputError` of the model's name, and is its ``__cause__``. Where it raises an
    `ArithmeticError` or gives what is not finite, the solver shortens its step, except where the search starts.
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
    _start: list[tuple[Floats, Floats]] = field(default_factory=list, init=False, repr=False, compare=False)
    """Parameters and gravity where the search starts."""

    def __post_init__(self) -> None:
        if not (isinstance(self.std, Real) and 0.0 < self.std < np.inf):
            told = f"residual `{self.name}` has the standard deviation {self.std!r}; expected a positive number"
            raise InputError(f"{told}, for all rows: where they differ, divide each row by its own and say std=1", field="std")
        # Tuples: models can be compared and hashed.
        object.__setattr__(self, "parameters", parameters_of(self.name, self.parameters))
        for what in ("columns", "joints", "links"):
            object.__setattr__(self, what, names(self.name, what, getattr(self, what)))

    # What the compiled part reads, and calls.

    @property
    def sees_gravity(self) -> bool:
        return self.gravity

    def evaluate_rows(
        self, x: Floats, gravity: Floats, table: Floats, seen: Sequence[int], slopes: bool
    ) -> tuple[Floats, Optional[Floats], Optional[Floats], Optional[Floats]]:
        """Values and, where wanted, derivatives by parameters, gravity and coordinates. A row of the table: coordinates and position
        readings of all joints, columns, then frames of links, each with its slopes."""
        x, gravity = read_only(x), read_only(gravity)
        observed = self._observed(gravity if self.gravity else None, read_only(table))
        values = self._tried(x, gravity, observed)
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

    def _observed(self, gravity: Optional[Floats], table: Floats) -> Observed:
        # coordinates, positions: n each; columns: c; links: 12 (1 + n) each.
        width = table.shape[1] - len(self.columns) - _FRAME * len(self.links)
        joints = width // (2 + _FRAME * len(self.links))
        first = 2 * joints + len(self.columns)
        columns = {name: table[:, 2 * joints + place] for place, name in enumerate(self.columns)}
        own = _FRAME * (1 + joints)
        frames = {link: table[:, first + place * own : first + (place + 1) * own] for place, link in enumerate(self.links)}
        return Observed(gravity, table[:, :joints], table[:, joints : 2 * joints], frames, columns)

    @property
    def _function(self) -> str:
        return f"the function of residual `{self.name}`"

    def _tried(self, x: Floats, gravity: Floats, observed: Observed) -> Floats:
        """Values, without which there must be none where the search starts: no step that is shorter would help."""
        if not self._start:
            self._start.append((x, gravity))
        # Gravity that it does not read is NaN.
        if not all(np.array_equal(own, start, equal_nan=True) for own, start in zip((x, gravity), self._start[0])):
            return self._values(x, observed)
        try:
            values = self._values(x, observed)
        except ArithmeticError as error:
            told = f"{self._function} raised {type(error).__name__} where the search starts (x = {x.tolist()}): {error}"
            raise InputError(told, field=self.name) from error
        wrong = np.flatnonzero(~np.isfinite(values))
        if wrong.size:
            told = f"{self._function} gives {values[wrong[0]]} where the search starts (x = {x.tolist()}): mend it, or start elsewhere"
            raise InputError(f"{told} (nominal=); coordinates of joints that `joints` does not name are NaN", field=self.name)
        return values

    def _values(self, x: Floats, observed: Observed) -> Floats:
        given = called(self._function, self.function, x, observed, field=self.name)
        values = returned(self._function, given, field=self.name, for_differences=True)
        if values.shape != (len(observed),):
            told = f"{self._function} gives shape {values.shape}; expected {(len(observed),)}, an entry each row; {ANY_NUMBER}"
            raise InputError(told, field=self.name)
        return values

    def __reduce__(self) -> Any:
        said = (self.name, self.function, self.std, tuple(self.parameters), tuple(self.columns), tuple(self.joints))
        return (ResidualModel, (*said, tuple(self.links), self.gravity, self.help))
