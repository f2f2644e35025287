from os import PathLike
from pathlib import PurePath
from typing import Any, Callable, Optional, Union, final

import numpy as np
from numpy.typing import NDArray

__all__ = ["Calibration", "Estimated", "Robot", "Session", "estimate", "read_recording", "run_program"]

_Path = Union[str, PathLike[str]]
_Progress = Optional[Callable[[str], object]]
_Floats = NDArray[np.float64]
_Ints = NDArray[np.int64]

def run_program(arguments: list[str]) -> int: ...
def read_recording(path: _Path, progress: _Progress = ...) -> tuple[list[str], _Floats, list[str]]: ...

@final
class Robot:
    @staticmethod
    def read(path: _Path) -> Robot: ...
    @staticmethod
    def read_urdf(path: _Path, base: str, tips: list[str]) -> Robot: ...
    @property
    def name(self) -> str: ...
    @property
    def joints(self) -> list[str]: ...
    @property
    def links(self) -> list[str]: ...

@final
class Session:
    @staticmethod
    def read(path: _Path, models: list[Any], progress: _Progress = ...) -> Session: ...
    @staticmethod
    def in_memory(
        said: str, recordings: list[tuple[str, list[str], _Floats]], models: list[Any], progress: _Progress = ...
    ) -> Session: ...
    @property
    def robot(self) -> str: ...
    @property
    def joints(self) -> list[str]: ...
    @property
    def channels(self) -> list[tuple[str, str]]: ...
    @property
    def doubts(self) -> list[str]: ...
    @property
    def inputs(self) -> list[PurePath]: ...
    @property
    def loads(self) -> list[Optional[str]]: ...
    @property
    def position(self) -> _Floats: ...
    @property
    def readings(self) -> _Floats: ...
    @property
    def std(self) -> _Floats: ...
    def calibrate(
        self, estimators: list[str], solver: Optional[str] = ..., progress: _Progress = ...
    ) -> Calibration: ...
    def check(self) -> tuple[str, str, str, bool]: ...
    def apply(
        self,
        calibration: _Path,
        estimator: str,
        position: _Floats,
        torque: _Floats,
        load: Optional[str],
        residual: bool,
        nominal: bool,
    ) -> tuple[_Floats, _Floats]: ...

@final
class Calibration:
    @property
    def json(self) -> str: ...
    @property
    def exit_code(self) -> int: ...
    def summary(self) -> str: ...
    def table(self) -> str: ...
    def page(self) -> str: ...
    def save(self, folder: _Path, overwrite: bool) -> bool: ...
    def residuals(self, place: int) -> tuple[_Ints, _Ints, _Floats, _Floats, _Floats, _Floats]: ...

_Combination = tuple[str, list[tuple[str, str, float]]]

@final
class Estimated:
    values: list[float]
    cost: float
    converged: bool
    termination: str
    iterations: list[tuple[float, float, float]]
    rank: int
    rows: int
    singular_values: list[float]
    determined: list[bool]
    undetermined: list[_Combination]
    weak: list[tuple[_Combination, float]]
    covariance: list[float]
    intervals: list[tuple[float, float]]
    without_uncertainty: Optional[str]
    weights: list[float]
    active: list[tuple[str, float]]

def estimate(
    blocks: list[Any],
    residuals: list[Any],
    constraints: list[Any],
    solver: str,
    options: str,
    relative: bool,
    progress: _Progress = ...,
) -> Estimated: ...
