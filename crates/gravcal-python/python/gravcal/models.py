"""Sensor models of one's own: vectorised functions, inside the joint problem and judged like gravcal's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import Any, Callable, Literal, Optional

import numpy as np
from numpy.typing import NDArray

from .arrays import called, read_only, returned
from .errors import InputError
from .estimation.differences import STEP, by_differences, mismatch
from .recording import Floats

__all__ = ["Poses", "SensorModel", "SensorParameter"]

_CONDITIONS = ("time", "temperature", "velocity", "direction")
_READS = ("torque", "coordinate", *_CONDITIONS)
# Columns of the table that the compiled part hands over: what `reads` may name in this order, then positions.
_PLACES = {name: place for place, name in enumerate(_READS)}
_TORQUE, _COORDINATE, _POSITIONS = _PLACES["torque"], _PLACES["coordinate"], len(_READS)


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

    def __post_init__(self) -> None:
        for what, text in (("name", self.name), ("unit", self.unit)):
            if not isinstance(text, str):
                raise InputError(f"the {what} of a parameter is {text!r}; expected text", field=what)
        if not _is_finite(self.limit) or self.limit <= 0.0:
            told = f"parameter `{self.name}` has the limit {self.limit!r}; expected a positive number of {self.unit}"
            raise InputError(told, field="limit")
        if not _is_finite(self.nominal):
            told = f"parameter `{self.name}` has the nominal value {self.nominal!r}; expected a number of {self.unit}"
            raise InputError(told, field="nominal")


def _is_finite(number: Any) -> bool:
    # NumPy's kinds of numbers are real, too.
    return isinstance(number, Real) and bool(np.isfinite(float(number)))


class Poses:
    """What a model may read, with an entry each pose; only of what its `reads` name, and of positions always. It cannot be written into."""

    # Made for every call: columns are taken when they are asked for.
    __slots__ = ("_reads", "_table", "joint")

    def __init__(self, joint: int, table: Floats, reads: Sequence[str]) -> None:
        self.joint = joint
        """Index of the joint whose sensor it is."""
        self._table, self._reads = read_only(table), reads

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
        return self._read("torque")

    @property
    def coordinate(self) -> Floats:
        """True coordinate of the joint, rad or m."""
        return self._read("coordinate")

    @property
    def time(self) -> Floats:
        """s since the session's first pose."""
        return self._read("time")

    @property
    def temperature(self) -> Floats:
        """°C of the joint's sensors."""
        return self._read("temperature")

    @property
    def velocity(self) -> Floats:
        """rad/s or m/s of the joint."""
        return self._read("velocity")

    @property
    def direction(self) -> Floats:
        """From which side the joint came: 1, 0 or -1."""
        return self._read("direction")

    def __len__(self) -> int:
        return len(self._table)

    def _read(self, name: str) -> Floats:
        if name not in self._reads:
            raise InputError(f'{name} is read, but `reads` does not name it: say reads=["{name}"]', field="reads")
        return self._column(_PLACES[name])

    def _column(self, place: int) -> Floats:
        column: Floats = self._table[:, place]
        return column

    def _are_known(self) -> NDArray[np.bool_]:
        """Whether all that may be read is a number, an entry each pose."""
        places = [_PLACES[name] for name in self._reads] + list(range(_POSITIONS, self._table.shape[1]))
        known: NDArray[np.bool_] = np.all(np.isfinite(self._table[:, places]), axis=1)
        return known


def names(model: str, what: str, given: Any) -> tuple[str, ...]:
    """A list of names, which a text is not, though it has letters."""
    if isinstance(given, str):
        raise InputError(f'{what} of model `{model}` is "{given}"; expected a list: {what}=["{given}"]', field=what)
    return tuple(given)


def parameters_of(model: str, given: Any) -> tuple[SensorParameter, ...]:
    """A list of parameters."""
    if isinstance(given, (str, SensorParameter)) or not hasattr(given, "__iter__"):
        raise InputError(f"parameters of model `{model}` is {given!r}; expected a list of SensorParameter", field="parameters")
    own = tuple(given)
    for place, parameter in enumerate(own):
        if not isinstance(parameter, SensorParameter):
            told = f"parameters[{place}] of model `{model}` is {parameter!r}; expected a SensorParameter(name, unit, limit)"
            raise InputError(told, field="parameters")
    return own


ANY_NUMBER = "it is called with any number of poses: take what it needs from its second argument, not from arrays outside"
"""What a function has missed that returns entries for other poses than it was given."""


@dataclass(frozen=True)
class SensorModel:
    """What a sensor does beyond gain and bias: a function that is added to its reading.

        torque       reading = torque_gain * torque + torque_bias + function(x, poses)
        position     coordinate = position_gain * reading + position_offset + function(x, poses)

    `function` is called with the parameters `x`, an array in the order of `parameters`, and with `Poses`, and returns an array with an
    entry each pose, however many there are. It cannot write into what it is given. A session names it for a joint:
    ``joint=[{"name": "joint2", "sensor_models": [{"kind": name}]}]``.

    A function that reads positions and conditions only is called for all poses at once, and for one where a single value is asked for.
    One that reads ``torque`` or ``coordinate``, which change with all unknowns, is called pose by pose with arrays of a few entries, and
    is slow: see the price in the book.

    What a function raises ends the work with an `InputError` of the model's name, and is its ``__cause__``. Where it raises an
    `ArithmeticError` or gives what is not finite, the solver shortens its step, except where the search starts.
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
    _tried: set[int] = field(default_factory=set, init=False, repr=False, compare=False)
    _checked: set[int] = field(default_factory=set, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        # Tuples: models can be compared and hashed.
        object.__setattr__(self, "parameters", parameters_of(self.name, self.parameters))
        object.__setattr__(self, "reads", names(self.name, "reads", self.reads))
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
        x, poses = read_only(x), Poses(joint, table, self.reads)
        if self._starts(joint, x):
            self._try(x, poses)
        if not slopes:
            return self._values(x, poses), None, None, None
        by_parameter = self._slopes(x, poses)
        if not (self.reads_torque or self.reads_coordinate):
            return self._values(x, poses), by_parameter, None, None
        values, along = self._along(x, joint, table)
        return values, by_parameter, along.get(_TORQUE), along.get(_COORDINATE)

    @property
    def _function(self) -> str:
        return f"the function of model `{self.name}`"

    def _starts(self, joint: int, x: Floats) -> bool:
        """Whether the search starts here. A pose's torque is not known there: only the first is tried."""
        if joint not in self._tried:
            return True
        if self.reads_torque or self.reads_coordinate:
            return False
        return all(own.nominal == number for own, number in zip(self.parameters, x))

    def _try(self, x: Floats, poses: Poses) -> None:
        """Refuses a function without values where the search starts: no step that is shorter would help."""
        try:
            values = self._values(x, poses)
        except ArithmeticError as error:
            told = f"{self._function} raised {type(error).__name__} where the search starts (x = {x.tolist()}): {error}"
            raise InputError(told, field=self.name) from error
        wrong = np.flatnonzero(poses._are_known() & ~np.isfinite(values))
        if wrong.size:
            place = int(wrong[0])
            where = f"where the search starts (x = {x.tolist()}), at the position reading {poses.position[place]:g}"
            raise InputError(f"{self._function} gives {values[place]} {where}: mend it, or start elsewhere (nominal=)", field=self.name)
        self._tried.add(poses.joint)

    def _values(self, x: Floats, poses: Poses) -> Floats:
        given = called(self._function, self.function, x, poses, field=self.name)
        values = returned(self._function, given, field=self.name, for_differences=True)
        if values.shape != (len(poses),):
            told = f"{self._function} gives shape {values.shape}; expected {(len(poses),)}, an entry each pose; {ANY_NUMBER}"
            raise InputError(told, field=self.name)
        return values

    def _slopes(self, x: Floats, poses: Poses) -> Floats:
        scale = np.array([abs(own.nominal) or own.limit for own in self.parameters])
        if self.jacobian is None:
            return by_differences(lambda x: self._values(x, poses), x, scale)
        what, expected = f"the jacobian of model `{self.name}`", (len(poses), len(x))
        slopes = returned(what, called(what, self.jacobian, x, poses, field=self.name), field=self.name)
        if slopes.shape != expected:
            told = f"{what} gives shape {slopes.shape}; expected {expected}, poses by parameters"
            raise InputError(told, field=self.name)
        if poses.joint not in self._checked:
            self._checked.add(poses.joint)
            found = by_differences(lambda x: self._values(x, poses), x, scale)
            wrong = mismatch(slopes, found, scale)
            if wrong is not None:
                told = (
                    f"{what} at pose {wrong[0]} by `{self.parameters[wrong[1]].name}` is "
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
        values = self._values(x, Poses(joint, stacked, self.reads)).reshape(-1, poses)
        slopes = {}
        for place, column in enumerate(columns):
            ahead, behind = 1 + 2 * place, 2 + 2 * place
            slopes[column] = (values[ahead] - values[behind]) / (parts[ahead, :, column] - parts[behind, :, column])
        return values[0], slopes

    def __reduce__(self) -> Any:
        said = (self.name, self.function, tuple(self.parameters), self.sensor, tuple(self.reads), self.jacobian)
        return (SensorModel, (*said, self.linear, self.affine_in_torque, self.help))
