"""Sensor models of one's own: vectorised functions, inside the joint problem and judged like gravcal's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Callable, Literal, Optional

import numpy as np

from .errors import InputError
from .estimation.differences import STEP, by_differences, mismatch
from .recording import Floats

__all__ = ["Poses", "SensorModel", "SensorParameter"]

_CONDITIONS = ("time", "temperature", "velocity", "direction")
_READS = ("torque", "coordinate", *_CONDITIONS)
# Columns of the table that the compiled part hands over.
_TORQUE, _COORDINATE, _POSITIONS = 0, 1, 6


@dataclass(frozen=True)
class SensorParameter:
    """What a model of a joint's sensor has to find; in results it is called ``joint2.name``."""

    name: str
    unit: str
    limit: float
    """Standard deviation beyond which a number would mislead, and is not given."""
    nominal: float = 0.0
    """Where the search starts."""
    equation: str = ""
    """In which it stands, such as ``reading = ... + wave * sin(position)``."""
    cure: str = ""
    """What would determine it where the readings do not, such as ``record poses all around``."""


class Poses:
    """What a model may read, with an entry each pose; only of what its `reads` name, and of positions always."""

    # Made for every call: columns are taken when they are asked for.
    __slots__ = ("_table", "joint")

    def __init__(self, joint: int, table: Floats) -> None:
        self.joint = joint
        """Index of the joint whose sensor it is."""
        self._table = table

    @property
    def position(self) -> Floats:
        """Position readings of the joint: rad, m or the sensor's own unit."""
        return self._column(_POSITIONS + self.joint)

    @property
    def positions(self) -> Floats:
        """Position readings of all joints, a column each."""
        all_joints: Floats = self._table[:, _POSITIONS:]
        return all_joints

    @property
    def torque(self) -> Floats:
        """True torque of the joint, N·m or N."""
        return self._column(_TORQUE)

    @property
    def coordinate(self) -> Floats:
        """True coordinate of the joint, rad or m."""
        return self._column(_COORDINATE)

    @property
    def time(self) -> Floats:
        """s since the session's first pose."""
        return self._column(2)

    @property
    def temperature(self) -> Floats:
        """°C of the joint's sensors."""
        return self._column(3)

    @property
    def velocity(self) -> Floats:
        """rad/s or m/s of the joint."""
        return self._column(4)

    @property
    def direction(self) -> Floats:
        """From which side the joint came: 1, 0 or -1."""
        return self._column(5)

    def __len__(self) -> int:
        return len(self._table)

    def _column(self, place: int) -> Floats:
        column: Floats = self._table[:, place]
        return column


@dataclass(frozen=True)
class SensorModel:
    """What a sensor does beyond gain and bias: a function that is added to its reading.

        torque       reading = torque_gain * torque + torque_bias + function(x, poses)
        position     coordinate = position_gain * reading + position_offset + function(x, poses)

    `function` is called with the parameters `x`, an array in the order of `parameters`, and with `Poses`, and returns an array with an
    entry each pose. A session names it for a joint: ``joint=[{"name": "joint2", "sensor_models": [{"kind": name}]}]``.

    A function that reads positions and conditions only is called for all poses at once. One that reads ``torque`` or ``coordinate``, which
    change with all unknowns, is called pose by pose with arrays of a few entries, and is slow: see the price in the book.
    """

    name: str
    function: Callable[[Floats, Poses], Any]
    parameters: Sequence[SensorParameter]
    sensor: Literal["torque", "position"] = "torque"
    reads: Sequence[Literal["torque", "coordinate", "time", "temperature", "velocity", "direction"]] = ()
    """Besides positions."""
    jacobian: Optional[Callable[[Floats, Poses], Any]] = None
    """Called like `function`; returns poses by parameters. It is compared with differences once. Without it: central differences."""
    linear: bool = False
    """Whether the function is a sum of parameters times functions without parameters."""
    affine_in_torque: bool = False
    """Whether a function that reads the torque is affine in it."""
    help: str = "a function in Python"
    _checked: set[int] = field(default_factory=set, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        unknown = [name for name in self.reads if name not in _READS]
        if unknown:
            raise InputError(f"model `{self.name}` reads `{unknown[0]}`; there is {', '.join(_READS)}", field="reads")
        if self.sensor not in ("torque", "position"):
            raise InputError(f"model `{self.name}` is of the sensor `{self.sensor}`; expected `torque` or `position`", field="sensor")
        if self.of_position and (self.reads_torque or self.reads_coordinate):
            raise InputError(f"model `{self.name}` is of a position sensor: it reads no torque and no coordinate", field="reads")
        if not self.parameters:
            raise InputError(f"model `{self.name}` has no parameters: there is nothing to find", field="parameters")

    # What the compiled part reads, and calls.

    @property
    def of_position(self) -> bool:
        return self.sensor == "position"

    @property
    def reads_torque(self) -> bool:
        return "torque" in self.reads

    @property
    def reads_coordinate(self) -> bool:
        return "coordinate" in self.reads

    @property
    def needs(self) -> list[str]:
        return [name for name in self.reads if name in _CONDITIONS]

    def evaluate(
        self, joint: int, x: Floats, table: Floats, slopes: bool
    ) -> tuple[Floats, Optional[Floats], Optional[Floats], Optional[Floats]]:
        """Values and, where wanted, derivatives by parameters, torque and coordinate."""
        poses = Poses(joint, table)
        if not slopes:
            return self._values(x, poses), None, None, None
        by_parameter = self._slopes(x, poses)
        if not (self.reads_torque or self.reads_coordinate):
            return self._values(x, poses), by_parameter, None, None
        values, along = self._along(x, joint, table)
        return values, by_parameter, along.get(_TORQUE), along.get(_COORDINATE)

    def _values(self, x: Floats, poses: Poses) -> Floats:
        values = self._array("function", self.function(x, poses))
        if values.shape != (len(poses),):
            told = f"the function of model `{self.name}` gives shape {values.shape}; expected {(len(poses),)}, an entry each pose"
            raise InputError(told, field=self.name)
        return values

    def _slopes(self, x: Floats, poses: Poses) -> Floats:
        scale = np.array([abs(own.nominal) or own.limit for own in self.parameters])
        if self.jacobian is None:
            return by_differences(lambda x: self._values(x, poses), x, scale)
        slopes, expected = self._array("jacobian", self.jacobian(x, poses)), (len(poses), len(x))
        if slopes.shape != expected:
            told = f"the jacobian of model `{self.name}` gives shape {slopes.shape}; expected {expected}, poses by parameters"
            raise InputError(told, field=self.name)
        if poses.joint not in self._checked:
            self._checked.add(poses.joint)
            found = by_differences(lambda x: self._values(x, poses), x, scale)
            wrong = mismatch(slopes, found, scale)
            if wrong is not None:
                told = (
                    f"the jacobian of model `{self.name}` at pose {wrong[0]} by `{self.parameters[wrong[1]].name}` is "
                    f"{slopes[wrong]:g}; differences give {found[wrong]:g}. Mend it, or leave it away"
                )
                raise InputError(told, field=self.name)
        return slopes

    def _along(self, x: Floats, joint: int, table: Floats) -> tuple[Floats, dict[int, Floats]]:
        """Values, and slopes along the columns that it reads: all by one call."""
        columns = [column for column, reads in ((_TORQUE, self.reads_torque), (_COORDINATE, self.reads_coordinate)) if reads]
        poses = len(table)
        stacked = np.tile(table, (1 + 2 * len(columns), 1))
        parts = stacked.reshape(-1, poses, table.shape[1])
        for place, column in enumerate(columns):
            step = STEP * np.maximum(1.0, np.abs(table[:, column]))
            parts[1 + 2 * place, :, column] += step
            parts[2 + 2 * place, :, column] -= step
        values = self._values(x, Poses(joint, stacked)).reshape(-1, poses)
        slopes = {}
        for place, column in enumerate(columns):
            ahead, behind = 1 + 2 * place, 2 + 2 * place
            slopes[column] = (values[ahead] - values[behind]) / (parts[ahead, :, column] - parts[behind, :, column])
        return values[0], slopes

    def _array(self, what: str, given: Any) -> Floats:
        try:
            return np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"the {what} of model `{self.name}`: expected numbers ({error})", field=self.name) from None

    def __reduce__(self) -> Any:
        said = (self.name, self.function, tuple(self.parameters), self.sensor, tuple(self.reads), self.jacobian)
        return (SensorModel, (*said, self.linear, self.affine_in_torque, self.help))
