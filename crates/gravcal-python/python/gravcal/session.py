"""Robots and sessions."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Optional, Union

import numpy as np

from . import _native
from .errors import InputError
from .log import LOG, logged
from .models import SensorModel
from .residuals import ResidualModel
from .recording import Floats, Path, Progress
from .result import Calibration
from .tabled import Summarised, for_python

__all__ = ["Check", "Robot", "Session"]

Table = Any
"""A DataFrame, or a mapping from names of columns to arrays of one length."""


class Robot:
    """A robot, as it is read by sessions: from `robot.toml` or from a URDF."""

    def __init__(self, native: _native.Robot, said: Union[str, dict[str, Any]]) -> None:
        self._native = native
        self._said = said

    @classmethod
    def from_toml(cls, path: Path) -> Robot:
        """Denavit-Hartenberg rows. Raises `InputError`, which tells file, line and field."""
        return cls(_native.Robot.read(path), os.path.abspath(path))

    @classmethod
    def from_urdf(cls, path: Path, *, base: str, tip: Union[str, Sequence[str]]) -> Robot:
        """The chain of a URDF from link `base` to link `tip`; several tips where it branches."""
        tips = [tip] if isinstance(tip, str) else list(tip)
        said = {"urdf": os.path.abspath(path), "base": base, "tip": tips[0] if len(tips) == 1 else tips}
        return cls(_native.Robot.read_urdf(path, base, tips), said)

    @property
    def name(self) -> str:
        return self._native.name

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints that have a coordinate of their own, in order."""
        return tuple(self._native.joints)

    @property
    def links(self) -> tuple[str, ...]:
        return tuple(self._native.links)

    def __repr__(self) -> str:
        return f"<gravcal.Robot {self.name}: {', '.join(self.joints)}>"

    def __reduce__(self) -> Any:
        return (_robot, (self._said,))


def _robot(said: Union[str, dict[str, Any]]) -> Robot:
    if isinstance(said, str):
        return Robot.from_toml(said)
    return Robot.from_urdf(said["urdf"], base=said["base"], tip=said["tip"])


@dataclass(frozen=True)
class Check(Summarised):
    """What a session can determine, before any solve."""

    complete: bool
    """Whether that is all that is asked for."""
    summary: str
    """One screen."""
    table: str
    """All of it."""
    fields: Mapping[str, Any]
    """What `gravcal check --json` prints."""


class Session:
    """Everything that is known beforehand of one calibration, and its static poses.

    From arrays: `position` and `torque` hold a row each static pose and a column each joint of the robot, in the units that are stated.
    A DataFrame's columns are named after the joints, in any order.

    `load` names what is attached: one of `loads` for all poses, or a name or `None` for each. `torque_std` is the standard deviation of
    each reading: one for all, one each joint, or one each reading; without it the noise is estimated. `gravity` is its magnitude in m/s²,
    or what `[gravity]` of a `session.toml` may say. Where `missing` is ``"nan"``, a torque that is NaN is a reading that is missing;
    otherwise NaN is refused, as it always is among positions.

    All else that a `session.toml` may say is said by the same names: ``joint=[{"name": "joint1", "torque_sign": "reversed"}]``,
    ``loss={"kind": "huber"}``, ``ask={"drop": ["gravity"]}``; what belongs to its ``[readings]`` in ``readings={...}``.

    `models` are sensor models of one's own, which `joint` may name, and residuals, which `residual` may: see `SensorModel` and
    `ResidualModel`. `columns` are further columns of the tables by their names, which these read, an entry each pose; NaN is an empty cell.

    Raises `InputError`.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        position: Any,
        torque: Any,
        position_unit: Union[str, Sequence[str]],
        torque_unit: Union[str, Sequence[str]],
        gravity: Union[float, Mapping[str, Any]],
        torque_std: Any = None,
        position_std: Union[None, float, Sequence[float]] = None,
        load: Union[None, str, Sequence[Optional[str]]] = None,
        loads: Sequence[Mapping[str, Any]] = (),
        missing: str = "refuse",
        readings: Optional[Mapping[str, Any]] = None,
        models: Sequence[Union[SensorModel, ResidualModel]] = (),
        columns: Optional[Mapping[str, Any]] = None,
        progress: Progress = None,
        **sections: Any,
    ) -> None:
        if missing not in ("refuse", "nan"):
            raise InputError(f"missing is `{missing}`; expected `refuse` or `nan`", field="missing")
        joints = robot.joints
        positions = _matrix("position", position, joints)
        torques = _matrix("torque", torque, joints)
        if len(torques) != len(positions):
            raise InputError(
                f"torque has {len(torques)} rows and position {len(positions)}: expected one each static pose",
                field="torque",
            )
        _refuse("position", positions, joints, np.isfinite(positions), "")
        finite = np.isfinite(torques) | (np.isnan(torques) if missing == "nan" else False)
        _refuse("torque", torques, joints, finite, '; missing="nan" says that a reading that is NaN is missing')

        further, columns = columns or {}, {f"position[{joint}]": positions[:, place] for place, joint in enumerate(joints)}
        for name, cells in further.items():
            column = np.asarray(cells, dtype=np.float64)
            if column.shape != (len(positions),):
                raise InputError(f"column `{name}` is {_shape(column)}: expected {len(positions)} entries, one each pose", field="columns")
            columns[name] = column
        read = [bool(np.isfinite(torques[:, place]).any()) for place in range(len(joints))]
        columns.update({f"torque[{joint}]": torques[:, place] for place, joint in enumerate(joints) if read[place]})
        of_torque: dict[str, Any] = {
            "columns": [f"torque[{joint}]" if here else "" for joint, here in zip(joints, read)],
            "unit": _plain(torque_unit),
        }
        if torque_std is not None and np.ndim(torque_std) == 2:
            stds = _matrix("torque_std", torque_std, joints)
            if stds.shape != torques.shape:
                raise InputError(f"torque_std is {_shape(stds)}, torque {_shape(torques)}", field="torque_std")
            columns.update({f"std[{joint}]": stds[:, place] for place, joint in enumerate(joints) if read[place]})
            of_torque["std_columns"] = [f"std[{joint}]" if here else "" for joint, here in zip(joints, read)]
        elif torque_std is not None:
            of_torque["std"] = _plain(torque_std)
        of_position: dict[str, Any] = {"columns": [f"position[{joint}]" for joint in joints], "unit": _plain(position_unit)}
        if position_std is not None:
            of_position["std"] = _plain(position_std)

        poses, recordings = [], {}
        for name, rows, attached in _parts(load, len(positions)):
            recordings[name] = {column: cells[rows] for column, cells in columns.items()}
            poses.append({"file": name} if attached is None else {"file": name, "load": attached})
        said = {
            "robot": robot._said,
            "gravity": dict(gravity) if isinstance(gravity, Mapping) else {"magnitude_m_per_s2": gravity},
            "readings": {**(readings or {}), "position": of_position, "torque": of_torque},
            "load": list(loads),
            "poses": poses,
        }
        twice = sorted(set(said) & set(sections))
        if twice:
            raise InputError(f"`{twice[0]}` is said by other arguments already", field=twice[0])
        self._build({**said, **sections}, recordings, models, progress)

    @classmethod
    def from_toml(
        cls, path: Path, *, models: Sequence[Union[SensorModel, ResidualModel]] = (), progress: Progress = None
    ) -> Session:
        """Reads a `session.toml` and all that it names. Raises `InputError`, which tells file, line and field."""
        session = cls.__new__(cls)
        session._native = _native.Session.read(path, list(models), logged(progress))
        session._source, session._models = os.path.abspath(path), tuple(models)
        session._log()
        return session

    @classmethod
    def from_dict(
        cls,
        said: Mapping[str, Any],
        recordings: Mapping[str, Table],
        *,
        models: Sequence[Union[SensorModel, ResidualModel]] = (),
        progress: Progress = None,
    ) -> Session:
        """What a `session.toml` would say, as a dictionary, with recordings in memory under the names that it says for files.

        A recording is a DataFrame, or a mapping from names of columns to arrays of one length; NaN is an empty cell. So instruments,
        clocks, temperatures and recordings in motion can come from arrays, too.
        """
        session = cls.__new__(cls)
        session._build(said, recordings, models, progress)
        return session

    def _build(
        self,
        said: Mapping[str, Any],
        recordings: Mapping[str, Table],
        models: Sequence[Union[SensorModel, ResidualModel]],
        progress: Progress,
    ) -> None:
        try:
            text = json.dumps(_plain(said), allow_nan=False)
        except (TypeError, ValueError) as error:
            raise InputError(f"the session says what no session.toml can: {error}") from None
        tables = [(name, *_table(name, table)) for name, table in recordings.items()]
        self._native = _native.Session.in_memory(text, tables, list(models), logged(progress))
        self._models = tuple(models)
        self._source: Union[str, tuple[str, list[tuple[str, list[str], Floats]]]] = (text, tables)
        self._log()

    def _log(self) -> None:
        LOG.info("%r is read", self)
        for doubt in self.doubts:
            LOG.warning(doubt)

    @property
    def robot(self) -> str:
        """Name of the robot."""
        return self._native.robot

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(self._native.joints)

    @property
    def position(self) -> Floats:
        """Position readings, a row each pose and a column each joint: rad, m, or the sensor's own unit."""
        return self._native.position

    @property
    def torque(self) -> Floats:
        """Torque readings, a row each pose and a column each joint; NaN where there is none."""
        torque: Floats = self._native.readings[:, : len(self.joints)]
        return torque

    @property
    def loads(self) -> tuple[Optional[str], ...]:
        """What is attached in each pose."""
        return tuple(self._native.loads)

    @property
    def doubts(self) -> tuple[str, ...]:
        """What of all that can hardly be so, in sentences."""
        return tuple(self._native.doubts)

    @property
    def files(self) -> tuple[str, ...]:
        """Every file that was read."""
        return tuple(str(path) for path in self._native.inputs)

    def __len__(self) -> int:
        """How many static poses there are."""
        return len(self._native.loads)

    def check(self) -> Check:
        """What the session can determine, and what would cure what it cannot."""
        text, summary, table, complete = self._native.check()
        return Check(complete, for_python(summary), table, json.loads(text))

    def calibrate(
        self,
        estimators: Union[None, str, Sequence[str]] = None,
        *,
        solver: Optional[str] = None,
        progress: Progress = None,
    ) -> Calibration:
        """Finds gains, biases, offsets and gravity, with their uncertainty.

        `estimators` and `solver` are chosen by name; without them the session's, else the sequential and the joint estimator with
        Levenberg-Marquardt. `progress` is called with what is being done, in a few words. Ctrl-C stops after the current iteration.
        """
        names = [estimators] if isinstance(estimators, str) else list(estimators or [])
        result = Calibration._of(self._native.calibrate(names, solver, logged(progress)), self._native.channels)
        LOG.info("%r", result)
        for doubt in result.doubts[len(self.doubts) :]:
            LOG.warning(doubt)
        return result

    def apply(
        self,
        calibration: Calibration,
        *,
        position: Any,
        torque: Any,
        estimator: str = "joint",
        residual: bool = False,
        load: Optional[str] = None,
        nominal: bool = False,
    ) -> tuple[Floats, Floats]:
        """What readings truly say, a row each sample: coordinates in the unit of the position readings (rad or m where that is the
        sensor's own), and torques in N·m (N where a joint slides).

        With `residual`, torques without that which carries gravity, with `load` attached. With `nominal`, nominal values are taken for
        what the calibration does not determine. NaN where a reading is missing or at an end of the sensor's range.
        """
        positions, torques = _matrix("position", position, self.joints), _matrix("torque", torque, self.joints)
        if positions.shape != torques.shape:
            raise InputError(f"position is {_shape(positions)}, torque {_shape(torques)}", field="torque")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "calibration.json")
            with open(path, "w", encoding="utf-8") as file:
                file.write(calibration.json)
            return self._native.apply(path, estimator, positions, torques, load if residual else None, residual, nominal)

    def __repr__(self) -> str:
        return f"<gravcal.Session {self.robot}: {len(self)} poses of {', '.join(self.joints)}>"

    def __reduce__(self) -> Any:
        return (_session, (self._source, self._models))


def _session(
    source: Union[str, tuple[str, list[tuple[str, list[str], Floats]]]], models: tuple[Union[SensorModel, ResidualModel], ...]
) -> Session:
    if isinstance(source, str):
        return Session.from_toml(source, models=models)
    text, tables = source
    recordings = {name: dict(zip(columns, cells.T)) for name, columns, cells in tables}
    return Session.from_dict(json.loads(text), recordings, models=models)


def _parts(load: Any, poses: int) -> list[tuple[str, slice, Optional[str]]]:
    """Rows with one load, in order: their name, where they are, and the load."""
    if load is None or isinstance(load, str):
        return [("poses", slice(0, poses), load)]
    names = [None if name is None else str(name) for name in load]
    if len(names) != poses:
        raise InputError(f"load has {len(names)} entries for {poses} poses: expected a name, or one each pose", field="load")
    parts, begin = [], 0
    for name, rows in groupby(names):
        end = begin + len(list(rows))
        parts.append((f"poses[{begin}:{end}]", slice(begin, end), name))
        begin = end
    return parts


def _matrix(what: str, given: Any, joints: Sequence[str]) -> Floats:
    """A row each pose, a column each joint; a copy only where the numbers are no 64-bit floats."""
    if hasattr(given, "columns") and hasattr(given, "to_numpy"):
        names = [str(name) for name in given.columns]
        if sorted(names) != sorted(joints):
            told = f"the columns of {what} are {', '.join(names)}; expected the joints {', '.join(joints)}"
            raise InputError(told, field=what)
        given = given[list(joints)].to_numpy()
    matrix = _numbers(what, given)
    if matrix.ndim == 1 and len(joints) == 1:
        matrix = matrix[:, np.newaxis]
    if matrix.ndim != 2 or matrix.shape[1] != len(joints):
        told = f"{what} is {_shape(matrix)}; expected a row each pose and a column each joint ({', '.join(joints)})"
        raise InputError(told, field=what)
    return matrix


def _numbers(what: str, given: Any) -> Floats:
    masked = isinstance(given, np.ma.MaskedArray)
    numbers = np.ma.filled(given.astype(np.float64), np.nan) if masked else np.asarray(given)
    if numbers.dtype.kind not in "fiu":
        raise InputError(f"{what} holds {numbers.dtype}; expected numbers", field=what)
    return np.asarray(numbers, dtype=np.float64)


def _refuse(what: str, matrix: Floats, joints: Sequence[str], good: Any, hint: str) -> None:
    if not good.all():
        row, column = np.argwhere(~good)[0]
        told = f"{what}[{row}, {column}] ({joints[column]}) is {matrix[row, column]}; expected a finite number{hint}"
        raise InputError(told, field=what)


def _shape(array: Floats) -> str:
    return " × ".join(str(length) for length in array.shape) or "a single number"


def _table(name: str, table: Table) -> tuple[list[str], Floats]:
    names = [str(column) for column in (table.columns if hasattr(table, "columns") else table)]
    cells = [_numbers(f"column `{column}` of `{name}`", table[column]) for column in (table.columns if hasattr(table, "columns") else table)]
    lengths = {cell.shape for cell in cells}
    if len(lengths) != 1 or len(next(iter(lengths))) != 1:
        told = ", ".join(f"{column} {_shape(cell)}" for column, cell in zip(names, cells))
        raise InputError(f"the columns of `{name}` are not of one length: {told}", field=name)
    for column, cell in zip(names, cells):
        if np.isinf(cell).any():
            raise InputError(f"column `{column}` of `{name}` holds an infinite number", field=name)
    return names, np.column_stack(cells)


def _plain(said: Any) -> Any:
    """The same of what JSON knows: arrays as lists, paths as text, without what is `None`."""
    if isinstance(said, Mapping):
        return {str(key): _plain(value) for key, value in said.items() if value is not None}
    if isinstance(said, (np.ndarray, np.generic)):
        return said.tolist()
    if isinstance(said, os.PathLike):
        return os.fspath(said)
    if isinstance(said, (list, tuple)):
        return [_plain(value) for value in said]
    return said
