"""Sensor models of one's own: vectorised functions, inside the joint problem and judged like gravcal's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Callable, Literal, Optional

import numpy as np

from .errors import InputError
from .estimation.differences import by_differences, mismatch
from .recording import Floats

__all__ = ["Poses", "SensorModel", "SensorParameter"]

_CONDITIONS = ("time", "temperature", "velocity", "direction")
_READS = ("torque", "coordinate", *_CONDITIONS)


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


@dataclass(frozen=True)
class Poses:
    """What a model may read, with an entry each pose; only of what its `reads` name, and of positions always."""

    joint: int
    """Index of the joint whose sensor it is."""
    positions: Floats
    """Position readings of all joints, a column each: rad, m or the sensor's own unit."""
    torque: Floats
    """True torque of the joint, N·m or N."""
    coordinate: Floats
    """True coordinate of the joint, rad or m."""
    time: Floats
    """s since the session's first pose."""
    temperature: Floats
    """°C of the joint's sensors."""
    velocity: Floats
    """rad/s or m/s of the joint."""
    direction: Floats
    """From which side the joint came: 1, 0 or -1."""

    @property
    def position(self) -> Floats:
        """Position readings of the joint itself."""
        own: Floats = self.positions[:, self.joint]
        return own

    def __len__(self) -> int:
        return len(self.positions)


@dataclass(frozen=True)
class SensorModel:
    """What a sensor does beyond gain and bias: a function that is added to its reading.

        torque       reading = torque_gain * torque + torque_bias + function(x, poses)
        position     coordinate = position_gain * reading + position_offset + function(x, poses)

    `function` is called with the parameters `x`, an array in the order of `parameters`, and with `Poses`, and returns an array with an
    entry each pose. A session names it for a joint: ``joint=[{"name": "joint2", "sensor_models": [{"kind": name}]}]``.

    A function that reads positions and conditions only is called for all poses at once. One that reads ``torque`` or ``coordinate``, which
    change with all unknowns, is called pose by pose with arrays of one entry, and is slow: some 10 µs a call.
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
        poses = _poses(joint, table)
        values = self._values(x, poses)
        if not slopes:
            return values, None, None, None
        by_torque = self._along(x, joint, table, 0) if self.reads_torque else None
        by_coordinate = self._along(x, joint, table, 1) if self.reads_coordinate else None
        return values, self._slopes(x, poses), by_torque, by_coordinate

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

    def _along(self, x: Floats, joint: int, table: Floats, column: int) -> Floats:
        """Slopes along a column of the table."""

        def moved(step: Floats) -> Floats:
            other = table.copy()
            other[:, column] += step[0]
            return self._values(x, _poses(joint, other))

        return by_differences(moved, np.zeros(1), np.maximum(1.0, np.abs(table[:1, column])))[:, 0]

    def _array(self, what: str, given: Any) -> Floats:
        try:
            return np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"the {what} of model `{self.name}`: expected numbers ({error})", field=self.name) from None

    def __reduce__(self) -> Any:
        said = (self.name, self.function, tuple(self.parameters), self.sensor, tuple(self.reads), self.jacobian)
        return (SensorModel, (*said, self.linear, self.affine_in_torque, self.help))


def _poses(joint: int, table: Floats) -> Poses:
    torque, coordinate, time, temperature, velocity, direction = table[:, :6].T
    return Poses(joint, table[:, 6:], torque, coordinate, time, temperature, velocity, direction)
