"""Robots and sessions."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Optional, Union

import numpy as np

from . import _native
from .arrays import floats, is_pandas, matrix, of_joints, refuse_cells, refuse_unaligned, shape_of
from .commands import file_of
from .errors import InputError, told_by_program
from .forked import use_threads
from .log import LOG, logged
from .models import SensorModel
from .residuals import ResidualModel
from .recording import Floats, Path, Progress
from .result import Calibration
from .said import as_arguments, merged_readings, plain, refuse_unsayable
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

    Where several arguments are DataFrames or Series, their indices must be the same.

    `load` names what is attached: one of `loads` for all poses, or a name or `None` for each (NaN of pandas is `None`). `torque_std` is the
    standard deviation of each reading: one for all, one each joint, or one each reading, NaN where it is not known; without it the noise is
    estimated. `gravity` is what `[gravity]` of a `session.toml` may say, or only its magnitude in m/s², which leaves its sign open. Where
    `missing` is ``"nan"``, a torque that is NaN is a reading that is missing; otherwise NaN is refused, as it always is among positions.

    Other sections of a `session.toml` are arguments of their names: ``joint=[{"name": "joint1", "torque_sign": "reversed"}]``,
    ``loss={"kind": "huber"}``, ``ask={"drop": ["gravity"]}``. What else its ``[readings]`` may say stands in `readings`, such as the range
    of the sensors: ``readings={"torque": {"lowest": -15, "highest": 15}}``.

    `models` are sensor models of one's own, which `joint` may name, and residuals, which `residual` may: see `SensorModel` and
    `ResidualModel`. `columns` are further columns of the tables, which these read: a DataFrame, or a mapping from names to arrays, an entry
    each pose; NaN is an empty cell.

    Raises `InputError`.
    """

    # What is set and nothing reads would be lost without a word.
    __slots__ = ("_models", "_native", "_source")

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
        position_std: Any = None,
        load: Any = None,
        loads: Optional[Sequence[Mapping[str, Any]]] = None,
        missing: str = "refuse",
        readings: Optional[Mapping[str, Any]] = None,
        models: Sequence[Union[SensorModel, ResidualModel]] = (),
        columns: Optional[Table] = None,
        progress: Progress = None,
        **sections: Any,
    ) -> None:
        joints = _joints(robot)
        refuse_unaligned(_indexed(position, torque, torque_std, load, columns))
        positions, torques = _readings(position, torque, joints, missing)
        read = [joint for place, joint in enumerate(joints) if np.isfinite(torques[:, place]).any()]
        if not read:
            raise InputError("torque holds no reading: expected a number in some pose", field="torque")
        of_position: dict[str, Any] = {"columns": [f"position[{joint}]" for joint in joints], "unit": plain(position_unit)}
        if position_std is not None:
            of_position["std"] = of_joints("position_std", position_std, joints)
        of_torque: dict[str, Any] = {"columns": _named("torque", joints, read), "unit": plain(torque_unit)}
        # A joint without a torque reading has no columns of them.
        tables = {"position": (positions, joints), "torque": (torques, read)}
        if _is_table(torque_std):
            of_torque["std_columns"] = _named("std", joints, read)
            tables["std"] = (_stds(torque_std, torques, joints), read)
        elif torque_std is not None:
            of_torque["std"] = of_joints("torque_std", torque_std, joints)
        cells = _further(columns, joints, len(positions))
        for what, (table, own) in tables.items():
            cells.update({f"{what}[{joint}]": table[:, joints.index(joint)] for joint in own})

        poses, recordings = [], {}
        for part, rows, attached in _parts(load, len(positions)):
            recordings[part] = {name: column[rows] for name, column in cells.items()}
            poses.append({"file": part} if attached is None else {"file": part, "load": attached})
        said = {
            "robot": robot._said,
            "gravity": _gravity(gravity),
            "readings": merged_readings(readings, {"position": of_position, "torque": of_torque}),
            "load": _loads(loads),
            "poses": poses,
        }
        twice = sorted(set(said) & set(sections))
        if twice:
            raise InputError(f"`{twice[0]}` is said by other arguments already", field=twice[0])
        try:
            self._build({**said, **sections}, recordings, models, progress)
        except InputError as error:
            raise as_arguments(error) from error.__cause__

    @classmethod
    def from_toml(
        cls, path: Path, *, models: Sequence[Union[SensorModel, ResidualModel]] = (), progress: Progress = None
    ) -> Session:
        """Reads a `session.toml` and all that it names. Raises `InputError`, which tells file, line and field."""
        session, own = cls.__new__(cls), _models(models)
        try:
            session._native = _native.Session.read(path, own, logged(progress))
        except InputError as error:
            if error.file is None and error.field is None:
                raise told_by_program(str(error), [os.fspath(path)]) from error.__cause__
            raise
        session._source, session._models = os.path.abspath(path), tuple(own)
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
        clocks, temperatures and recordings in motion can come from arrays, too:

            Session.from_dict({..., "poses": [{"file": "a"}]}, recordings={"a": {"q1": ..., "y1": ...}})
        """
        if not isinstance(said, Mapping):
            raise InputError(f"said is {said!r}; expected a dictionary. Of a file: Session.from_toml", field="said")
        if not isinstance(recordings, Mapping):
            raise InputError("recordings are no dictionary; expected tables by the names that `said` says for files", field="recordings")
        session = cls.__new__(cls)
        session._build(said, recordings, models, progress)
        _check_read(said, recordings)
        return session

    def _build(
        self,
        said: Mapping[str, Any],
        recordings: Mapping[str, Table],
        models: Sequence[Union[SensorModel, ResidualModel]],
        progress: Progress,
    ) -> None:
        own, document = _models(models), plain(said)
        refuse_unsayable(document)
        text = json.dumps(document, allow_nan=False)
        tables = [(name, *_table(name, table)) for name, table in recordings.items()]
        self._native = _native.Session.in_memory(text, tables, own, logged(progress))
        self._models = tuple(own)
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
        use_threads()
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
        use_threads()
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
        if load is not None and not residual:
            raise InputError(f"load is {load!r}, which counts only with residual=True: say both, or leave it away", field="load")
        refuse_unaligned([("position", "position", position), ("torque", "torque", torque)])
        positions, torques = matrix("position", position, self.joints), matrix("torque", torque, self.joints)
        if positions.shape != torques.shape:
            raise InputError(f"position is {shape_of(positions)}, torque {shape_of(torques)}", field="torque")
        with file_of(calibration) as path:
            return self._native.apply(path, estimator, positions, torques, load, residual, nominal)

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


def _check_read(said: Mapping[str, Any], recordings: Mapping[str, Table]) -> None:
    """Refuses a recording that nothing reads: its name is misspelt in one of the two."""
    entries = [entry for key in ("poses", "validation") for entry in _entries(said.get(key))]
    named = [str(entry["file"]) for entry in entries if isinstance(entry, Mapping) and "file" in entry]
    unread = [str(name) for name in recordings if name not in named]
    if unread:
        raise InputError(
            f"recordings: nothing reads {', '.join(unread)}; `file` of poses and validation names {', '.join(named) or 'nothing'}",
            field="recordings",
        )


def _entries(section: Any) -> Sequence[Any]:
    return section if isinstance(section, (list, tuple)) else [section] if isinstance(section, Mapping) else []


def _joints(robot: Any) -> Sequence[str]:
    """Of the robot, which is no path."""
    if isinstance(robot, Robot):
        return robot.joints
    if isinstance(robot, (str, os.PathLike)):
        path = os.fspath(robot)
        cure = f'Robot.from_toml("{path}")' if str(path).endswith(".toml") else f'Robot.from_urdf("{path}", base=..., tip=...)'
        raise InputError(f'robot is "{path}"; expected a Robot: {cure}', field="robot")
    raise InputError(f"robot is of type {type(robot).__name__}; expected a Robot, as by Robot.from_toml", field="robot")


def _models(models: Any) -> list[Any]:
    if isinstance(models, (SensorModel, ResidualModel)):
        raise InputError(f"models is one model; expected a list: models=[{models.name}]", field="models")
    if isinstance(models, (str, Mapping)) or not hasattr(models, "__iter__"):
        raise InputError(f"models is {models!r}; expected a list of SensorModel and ResidualModel", field="models")
    own = list(models)
    for place, model in enumerate(own):
        if not isinstance(model, (SensorModel, ResidualModel)):
            raise InputError(f"models[{place}] is {model!r}; expected a SensorModel or a ResidualModel", field="models")
    return own


def _indexed(position: Any, torque: Any, torque_std: Any, load: Any, columns: Any) -> list[tuple[str, str, Any]]:
    """What has a row each pose, with name and field."""
    given = [("position", "position", position), ("torque", "torque", torque), ("load", "load", load)]
    if _is_table(torque_std):
        given.append(("torque_std", "torque_std", torque_std))
    if is_pandas(columns):
        return [*given, ("columns", "columns", columns)]
    further = columns.items() if isinstance(columns, Mapping) else ()
    return [*given, *((f'columns["{name}"]', "columns", column) for name, column in further)]


def _is_table(given: Any) -> bool:
    """Whether it has rows and columns, if they are of one length."""
    try:
        return np.ndim(given) == 2
    except ValueError:
        return False


def _readings(position: Any, torque: Any, joints: Sequence[str], missing: str) -> tuple[Floats, Floats]:
    """Positions and torques, a row each pose, judged."""
    if missing not in ("refuse", "nan"):
        raise InputError(f"missing is `{missing}`; expected `refuse` or `nan`", field="missing")
    positions, torques = matrix("position", position, joints), matrix("torque", torque, joints)
    if len(positions) == 0:
        raise InputError("position has no rows: there are no poses", field="position")
    if len(torques) != len(positions):
        told = f"torque has {len(torques)} rows and position {len(positions)}: expected one each static pose"
        raise InputError(told, field="torque")
    refuse_cells("position", positions, joints, np.isfinite(positions), "a finite number")
    good = np.isfinite(torques) | (np.isnan(torques) if missing == "nan" else False)
    refuse_cells("torque", torques, joints, good, 'a finite number; missing="nan" says that a reading that is NaN is missing')
    return positions, torques


def _named(what: str, joints: Sequence[str], read: Sequence[str]) -> list[str]:
    """The column of each joint, none where it has no torque reading."""
    return [f"{what}[{joint}]" if joint in read else "" for joint in joints]


def _stds(given: Any, torques: Floats, joints: Sequence[str]) -> Floats:
    """Standard deviations of all readings; NaN is one that is not known."""
    stds = matrix("torque_std", given, joints)
    if stds.shape != torques.shape:
        raise InputError(f"torque_std is {shape_of(stds)}, torque {shape_of(torques)}", field="torque_std")
    good = np.isnan(stds) | (np.isfinite(stds) & (stds > 0.0))
    refuse_cells("torque_std", stds, joints, good, "a positive number, or NaN where it is not known")
    return stds


def _further(columns: Any, joints: Sequence[str], poses: int) -> dict[str, Floats]:
    """Columns of the user's own; NaN is an empty cell."""
    if columns is None:
        return {}
    if not (isinstance(columns, Mapping) or hasattr(columns, "columns")):
        told = f"columns is of type {type(columns).__name__}; expected a DataFrame, or a mapping from names to arrays"
        raise InputError(told, field="columns")
    taken = {f"{what}[{joint}]" for what in ("position", "torque", "std") for joint in joints}
    found = {}
    for name in columns.columns if hasattr(columns, "columns") else columns:
        if str(name) in taken:
            raise InputError(f"column `{name}` has a name of gravcal's own: give it another, or say it by its argument", field="columns")
        column = floats(f"column `{name}`", columns[name], field="columns", masked_is_nan=True)
        if column.shape != (poses,):
            raise InputError(f"column `{name}` is {shape_of(column)}: expected {poses} entries, one each pose", field="columns")
        if np.isinf(column).any():
            place = int(np.argmax(np.isinf(column)))
            told = f"column `{name}`[{place}] is {column[place]}; expected a finite number, or NaN for an empty cell"
            raise InputError(told, field="columns")
        found[str(name)] = column
    return found


def _gravity(given: Any) -> dict[str, Any]:
    if isinstance(given, Mapping):
        return dict(given)
    strength = plain(given)
    if not isinstance(strength, (int, float)) or not np.isfinite(strength):
        told = f"gravity is {given!r}; expected its strength in m/s², or " + '{"magnitude_m_per_s2": 9.81, "hemisphere": [0, 0, -1]}'
        raise InputError(told, field="gravity")
    return {"magnitude_m_per_s2": strength}


def _loads(loads: Any) -> list[Any]:
    if isinstance(loads, (str, Mapping)) or not (loads is None or hasattr(loads, "__iter__")):
        raise InputError(f"loads is {loads!r}; expected a list with a dictionary for each load", field="loads")
    return [] if loads is None else list(loads)


def _parts(load: Any, poses: int) -> list[tuple[str, slice, Optional[str]]]:
    """Rows with one load, in order: their name, where they are, and the load."""
    if load is None or isinstance(load, str):
        return [("poses", slice(0, poses), None if load is None else _load("load", load))]
    names = _attached(load)
    if len(names) != poses:
        raise InputError(f"load has {len(names)} entries for {poses} poses: expected a name, or one each pose", field="load")
    parts, begin = [], 0
    for name, rows in groupby(names):
        end = begin + len(list(rows))
        parts.append((f"poses[{begin}:{end}]", slice(begin, end), name))
        begin = end
    return parts


def _attached(load: Any) -> list[Optional[str]]:
    """What is attached in each pose; what is missing in pandas is nothing."""
    if isinstance(load, Mapping) or not hasattr(load, "__iter__") or np.ndim(load) == 0:
        raise InputError(f"load is {load!r}; expected the name of a load, or a name or None for each pose", field="load")
    given = [None if absent else name for name, absent in zip(load, load.isna())] if is_pandas(load) else list(load)
    return [None if _is_nothing(name) else _load(f"load[{place}]", name) for place, name in enumerate(given)]


def _is_nothing(name: Any) -> bool:
    # NaN is what a list from pandas has where nothing is attached.
    return name is None or (isinstance(name, float) and name != name)


def _load(what: str, name: Any) -> str:
    if not isinstance(name, str) or not name:
        told = f"{what} is {name!r}; expected the name of a load, or None where nothing is attached"
        raise InputError(told, field="load")
    return str(name)


def _table(name: str, table: Table) -> tuple[list[str], Floats]:
    if not (isinstance(table, Mapping) or hasattr(table, "columns")):
        told = f"recording `{name}` is of type {type(table).__name__}; expected a DataFrame, or a mapping from names of columns to arrays"
        raise InputError(told, field=name)
    columns = list(table.columns if hasattr(table, "columns") else table)
    refuse_unaligned((f"column `{column}` of `{name}`", name, table[column]) for column in columns)
    names = [str(column) for column in columns]
    cells = [floats(f"column `{column}` of `{name}`", table[column], field=name, masked_is_nan=True) for column in columns]
    lengths = {cell.shape for cell in cells}
    if len(lengths) != 1 or len(next(iter(lengths))) != 1:
        told = ", ".join(f"{column} {shape_of(cell)}" for column, cell in zip(names, cells)) or "it has none"
        raise InputError(f"the columns of `{name}` are not of one length: {told}", field=name)
    for column, cell in zip(names, cells):
        if np.isinf(cell).any():
            raise InputError(f"column `{column}` of `{name}` holds an infinite number", field=name)
    return names, np.column_stack(cells)
