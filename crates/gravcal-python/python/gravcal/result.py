"""What estimators answer: the contents of `calibration.json`, to the last bit."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from .compared import Compared
from .errors import InputError
from .recording import Floats, Path
from .shown import show_in_browser, show_in_rerun
from .tabled import Summarised, for_python

__all__ = ["Calibration", "Covariance", "EstimatorResult", "Gravity", "Parameter", "Residuals", "Undetermined"]


_EVERYTHING = "everything"
"""What an estimator calls undetermined that had nothing to read."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a sensor. What is undetermined has neither `value` nor `std`, but says `why`."""

    name: str
    unit: str
    convention: str
    """The equation in which it stands."""
    value: Optional[float]
    std: Optional[float]
    interval: Optional[tuple[float, float]]
    """In which it lies with 95 %."""
    determined: bool
    held: Optional[str]
    """Why it is held at its value, where it is."""
    asked: bool
    """Whether the session asks for it."""
    nominal: Optional[float]
    why: Optional[str]
    """Why it is undetermined."""
    cure: Optional[str]
    """What would determine it."""


@dataclass(frozen=True)
class Gravity:
    """Gravity in base coordinates, m/s²."""

    vector: tuple[float, float, float]
    std: tuple[float, float, float]
    interval: tuple[tuple[float, float], ...]
    """Of each component, with 95 %."""
    cone95_deg: Optional[float]
    """Half the angle of the cone around it in which its direction lies with 95 %."""


@dataclass(frozen=True, eq=False)
class Covariance(Compared):
    """Of all parameters that have one, gravity's components among them; SI units and radians."""

    names: tuple[str, ...]
    matrix: Floats

    def of(self, *names: str) -> Floats:
        """The rows and columns of these names."""
        unknown = [name for name in names if name not in self.names]
        if unknown:
            raise KeyError(f"no covariance of {', '.join(unknown)}; there is one of {', '.join(self.names)}")
        places = [self.names.index(name) for name in names]
        part: Floats = self.matrix[np.ix_(places, places)]
        return part


@dataclass(frozen=True)
class Undetermined:
    """A combination of parameters of which the readings say nothing."""

    combination: str
    parameters: tuple[str, ...]
    why: str
    cure: str


@dataclass(frozen=True, eq=False)
class Residuals(Compared):
    """One entry a reading, in its unit: prediction less reading."""

    channels: tuple[str, ...]
    """Names of what `channel` counts: a joint's torque sensor, or an axis of an instrument."""
    units: tuple[str, ...]
    pose: NDArray[np.int64]
    channel: NDArray[np.int64]
    residual: Floats
    before: Floats
    """With sensors at their nominal values."""
    std: Floats
    """Standard deviation that the fit assumed."""
    weight: Floats
    """How much a robust loss counts it, from 0 to 1."""

    def __len__(self) -> int:
        return len(self.residual)

    def of(self, channel: str) -> Floats:
        """Those of one channel."""
        if channel not in self.channels:
            raise KeyError(f"there is no channel `{channel}`; there is {', '.join(self.channels)}")
        of: Floats = self.residual[self.channel == self.channels.index(channel)]
        return of

    def to_pandas(self) -> Any:
        """A DataFrame (needs pandas)."""
        import pandas

        columns = {"pose": self.pose, "channel": [self.channels[place] for place in self.channel]}
        floats = {"residual": self.residual, "before": self.before, "std": self.std, "weight": self.weight}
        return pandas.DataFrame({**columns, **floats})


@dataclass(frozen=True, eq=False, repr=False)
class EstimatorResult(Compared):
    """The answer of one estimator."""

    name: str
    verdict: str
    """``determined``, ``partly-determined`` or ``failed``."""
    termination: str
    """Why it ended."""
    iterations: int
    gravity: Optional[Gravity]
    parameters: Mapping[str, Parameter]
    covariance: Covariance
    undetermined: tuple[Undetermined, ...]
    notes: tuple[str, ...]
    residuals: Residuals
    fields: Mapping[str, Any]
    """All that `calibration.json` says of it."""

    def __getitem__(self, name: str) -> Parameter:
        try:
            return self.parameters[name]
        except KeyError:
            raise KeyError(f"there is no parameter `{name}`; there is {', '.join(self.parameters)}") from None

    def __repr__(self) -> str:
        known = sum(parameter.determined for parameter in self.parameters.values())
        told = f"{known} of {len(self.parameters)} parameters determined, {len(self.residuals)} residuals"
        return f"<gravcal.EstimatorResult {self.name}: {self.verdict}, {told}>"

    def to_pandas(self) -> Any:
        """A DataFrame with a row each parameter (needs pandas)."""
        import pandas

        rows = [
            {
                "value": parameter.value,
                "std": parameter.std,
                "low": parameter.interval[0] if parameter.interval else None,
                "high": parameter.interval[1] if parameter.interval else None,
                "unit": parameter.unit,
                "determined": parameter.determined,
                "why": parameter.why,
                "cure": parameter.cure,
            }
            for parameter in self.parameters.values()
        ]
        return pandas.DataFrame(rows, index=pandas.Index(list(self.parameters), name="parameter"))


@dataclass(frozen=True)
class _Shown:
    """What needs the session: kept as it is until somebody wants it, or it is pickled."""

    native: Optional[_native.Calibration]
    texts: Optional[tuple[str, str, str]] = None

    def summary(self) -> str:
        return for_python(self.native.summary()) if self.native else self._kept()[0]

    def table(self) -> str:
        return self.native.table() if self.native else self._kept()[1]

    def page(self) -> str:
        return self.native.page() if self.native else self._kept()[2]

    def without_session(self) -> _Shown:
        return _Shown(None, (self.summary(), self.table(), self.page()))

    def _kept(self) -> tuple[str, str, str]:
        assert self.texts is not None
        return self.texts


class Calibration(Summarised, Mapping[str, EstimatorResult]):
    """The answers of all estimators that ran, by name. It can be copied, and pickled without its session."""

    def __init__(self, text: str, results: dict[str, EstimatorResult], shown: _Shown, exit_code: int) -> None:
        self._text = text
        self._results = results
        self._shown = shown
        self._exit_code = exit_code

    @classmethod
    def _of(cls, native: _native.Calibration, channels: list[tuple[str, str]]) -> Calibration:
        text = native.json
        results = {}
        for place, fields in enumerate(json.loads(text)["estimators"]):
            names, units = tuple(name for name, _ in channels), tuple(unit for _, unit in channels)
            residuals = Residuals(names, units, *native.residuals(place))
            results[fields["name"]] = _estimator(fields, residuals)
        return cls(text, results, _Shown(native), native.exit_code)

    def __getitem__(self, estimator: str) -> EstimatorResult:
        try:
            return self._results[estimator]
        except KeyError:
            raise KeyError(f"estimator `{estimator}` did not run; these did: {', '.join(self._results)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._results)

    def __len__(self) -> int:
        return len(self._results)

    @property
    def json(self) -> str:
        """`calibration.json`, as the program writes it."""
        return self._text

    @property
    def doubts(self) -> tuple[str, ...]:
        """What of the session can hardly be so."""
        return tuple(json.loads(self._text).get("doubts", ()))

    @property
    def exit_code(self) -> int:
        """That of `gravcal calibrate`: 0 determined, 3 partly, 4 no answer to rely on."""
        return self._exit_code

    @property
    def summary(self) -> str:
        """One screen, as `gravcal calibrate` prints it: doubts, the verdict, what to do, a line each joint, gravity."""
        return self._shown.summary()

    @property
    def table(self) -> str:
        """All tables: `table.txt`, and what `gravcal calibrate --full` prints."""
        return self._shown.table()

    @property
    def page(self) -> str:
        """`report.html`: one page without any request to a network."""
        return self._shown.page()

    def save(self, folder: Path, *, overwrite: bool = False) -> bool:
        """Writes what `gravcal calibrate` writes into its folder, for `gravcal apply`, `export` and `compare`.

        False where the same is there already. Raises `InputError` where other results are, unless `overwrite`.
        """
        if self._shown.native is None:
            raise InputError("this calibration was pickled without its session: save the original, or write `json`")
        return self._shown.native.save(folder, overwrite)

    def show(self, where: Literal["browser", "rerun"] = "browser", *, estimator: str = "joint") -> Optional[str]:
        """Shows the report in a browser, and gives the path of its page; without a browser it warns. Or in Rerun (needs `rerun-sdk`) the
        table, and an estimator's residuals pose by pose, before and after. What is shown in Rerun goes to its recording of the moment
        (`rerun.init`, `rerun.save`), else to a new viewer.

        `gravcal calibrate --rerun`, of a program that is built with it, also shows the arm.
        """
        if where == "browser":
            return str(show_in_browser(self.page))
        if where != "rerun":
            raise InputError(f"results are shown in `browser` or `rerun`, not in `{where}`", field="where")
        show_in_rerun(self.table, self[estimator].residuals)
        return None

    def __repr__(self) -> str:
        told = ", ".join(f"{name}: {result.verdict}" for name, result in self._results.items())
        return f"<gravcal.Calibration {told}>"

    def __copy__(self) -> Calibration:
        return Calibration(self._text, self._results, self._shown, self._exit_code)

    def __deepcopy__(self, memo: dict[int, Any]) -> Calibration:
        return Calibration(self._text, copy.deepcopy(self._results, memo), self._shown, self._exit_code)

    def __reduce__(self) -> Any:
        shown = self._shown.without_session()
        return (Calibration, (self._text, self._results, shown, self._exit_code))


def _estimator(fields: Mapping[str, Any], residuals: Residuals) -> EstimatorResult:
    undetermined = tuple(
        Undetermined(one["combination"], tuple(one["parameters"]), one["why"], one["cure"])
        for one in fields["undetermined"]
    )
    covariance = fields["covariance"]
    names = tuple(covariance["order"])
    matrix = np.array(covariance["matrix"], dtype=np.float64).reshape(len(names), len(names))
    parameters = {one["name"]: _parameter(one, undetermined) for one in fields["parameters"]}
    return EstimatorResult(
        name=fields["name"],
        verdict=fields["verdict"],
        termination=fields["termination"],
        iterations=fields["iterations"],
        gravity=_gravity(fields["gravity"]),
        parameters=parameters,
        covariance=Covariance(names, matrix),
        undetermined=undetermined,
        notes=tuple(fields["notes"]),
        residuals=residuals,
        fields=fields,
    )


def _parameter(fields: Mapping[str, Any], undetermined: tuple[Undetermined, ...]) -> Parameter:
    concerns = {fields["name"], _EVERYTHING}
    lacking = next((one for one in undetermined if not concerns.isdisjoint(one.parameters)), None)
    if fields["determined"]:
        lacking = None
    return Parameter(
        name=fields["name"],
        unit=fields["unit"],
        convention=fields["convention"],
        value=fields["value"],
        std=fields["std"],
        interval=_pair(fields["ci95"]),
        determined=fields["determined"],
        held=fields["held"],
        asked=fields["asked"],
        nominal=fields.get("nominal"),
        why=lacking.why if lacking else None,
        cure=lacking.cure if lacking else None,
    )


def _gravity(fields: Optional[Mapping[str, Any]]) -> Optional[Gravity]:
    if fields is None:
        return None
    x, y, z = fields["vector_m_per_s2"]
    std_x, std_y, std_z = fields["std_m_per_s2"]
    interval = tuple((low, high) for low, high in fields["ci95_m_per_s2"])
    return Gravity((x, y, z), (std_x, std_y, std_z), interval, fields["cone95_deg"])


def _pair(ends: Union[list[float], None]) -> Optional[tuple[float, float]]:
    return None if ends is None else (ends[0], ends[1])
