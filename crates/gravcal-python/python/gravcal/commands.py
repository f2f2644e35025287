"""The program's other commands, on files: each is the command of that name, run as `python -m gravcal`."""

from __future__ import annotations

import csv
import json
import os
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Optional, Union

from .errors import InputError, told_by_program, without_file
from .log import LOG
from .recording import Path
from .result import Calibration
from .tabled import Tabled

__all__ = ["Comparison", "Inspection", "Study", "apply", "compare", "export", "inspect", "simulate", "study"]

_MOVED = 3


@dataclass(frozen=True)
class Inspection(Tabled):
    """What is in a recording."""

    table: str
    fields: Mapping[str, Any]
    """What `gravcal inspect --json` prints."""


@dataclass(frozen=True)
class Comparison(Tabled):
    """Which sensor moved between calibrations."""

    moved: bool
    """Whether any did."""
    table: str
    fields: Mapping[str, Any]
    """What `gravcal compare --json` prints."""


@dataclass(frozen=True)
class Study(Tabled):
    """What a study comes to."""

    table: str
    """`report.txt`."""
    measures: tuple[Mapping[str, Union[str, float, None]], ...]
    """`measures.csv`: an entry each point, estimator and quantity, with its rms error, that over the bound, and how often 95 % intervals hold
    the truth. `None` where there is no number."""
    folder: str
    """Where all of it is, with figures and `study.html`."""

    def to_pandas(self) -> Any:
        """A DataFrame of the measures (needs pandas)."""
        import pandas

        return pandas.DataFrame([dict(measure) for measure in self.measures])


def study(path: Path, output: Path, *, threads: Optional[int] = None) -> Study:
    """Runs the trials of a study that are missing in its folder for results, and tells what they come to."""
    words = ["study", "run", _path(path), "--output", _path(output), "--quiet"]
    _run(words + (["--threads", str(threads)] if threads is not None else []))
    with open(os.path.join(output, "measures.csv"), encoding="utf-8", newline="") as file:
        measures = tuple({name: _cell(text) for name, text in row.items()} for row in csv.DictReader(file))
    with open(os.path.join(output, "report.txt"), encoding="utf-8") as file:
        return Study(file.read(), measures, os.fspath(output))


def _cell(text: str) -> Union[str, float, None]:
    try:
        return float(text) if text else None
    except ValueError:
        return text


def inspect(path: Path) -> Inspection:
    """What is in a recording: columns, rates, gaps, what they perhaps mean, and which poses it holds."""
    fields = json.loads(_run(["inspect", _path(path), "--json", "--quiet"])[1])
    return Inspection(_run(["inspect", _path(path), "--quiet"])[1], fields)


def compare(*calibrations: Union[Path, Calibration], estimator: str = "joint") -> Comparison:
    """Which sensor moved between calibrations of one robot, in the order of their time."""
    with ExitStack() as stack:
        paths = [stack.enter_context(file_of(calibration)) for calibration in calibrations]
        words = ["compare", *paths, "--estimator", estimator]
        code, text = _run([*words, "--json"], good=(0, _MOVED))
        return Comparison(code == _MOVED, _run(words, good=(0, _MOVED))[1], json.loads(text))


def export(
    calibration: Union[Path, Calibration],
    to: str,
    *,
    estimator: Optional[str] = None,
    nominal: bool = False,
    session: Optional[Path] = None,
) -> str:
    """A calibration for a driver, a program, a robot description or a paper: `ros2`, `urdf` and `mujoco` (they need `session`, where the
    calibration is not in its folder), `payload`, `c`, `python`, `csv`, `markdown`, `latex`."""
    with file_of(calibration) as path:
        words = ["export", path, "--to", to]
        words += ["--estimator", estimator] if estimator else []
        words += ["--session", _path(session)] if session else []
        words += ["--nominal"] if nominal else []
        return _run(words)[1]


def apply(
    calibration: Union[Path, Calibration],
    recording: Path,
    output: Path,
    *,
    session: Optional[Path] = None,
    residual: bool = False,
    load: Optional[str] = None,
    nominal: bool = False,
    overwrite: bool = False,
) -> None:
    """Writes the same recording with true torques and angles; with `residual`, torques without that which carries gravity.

    Of arrays: `Session.apply`.
    """
    if load is not None and not residual:
        raise InputError(f"load is {load!r}, which counts only with residual=True: say both, or leave it away", field="load")
    with file_of(calibration) as path:
        words = ["apply", path, _path(recording), _path(output), "--quiet"]
        words += ["--session", _path(session)] if session else []
        words += ["--load", load] if load is not None else []
        flags = {"--residual": residual, "--nominal": nominal, "--overwrite": overwrite}
        _run(words + [flag for flag, given in flags.items() if given])


def simulate(path: Path, output: Path, *, trial: int = 0, overwrite: bool = False) -> str:
    """Writes a session with known truth into a folder; gives the path of its `session.toml`."""
    words = ["simulate", _path(path), "--output", _path(output), "--trial", str(trial)]
    _run(words + (["--overwrite"] if overwrite else []))
    return os.path.join(os.fspath(output), "session.toml")


@contextmanager
def file_of(calibration: Union[Path, Calibration]) -> Iterator[str]:
    """The file of a calibration."""
    if not isinstance(calibration, Calibration):
        yield _path(calibration)
        return
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "calibration.json")
        with open(path, "w", encoding="utf-8") as file:
            file.write(calibration.json)
        try:
            yield path
        except InputError as error:
            raise without_file(error, path, "the calibration") from error.__cause__


def _path(path: Path) -> str:
    """So that the program takes it for no option."""
    given = os.fspath(path)
    return os.path.join(os.curdir, given) if given.startswith("-") else given


def _run(arguments: list[str], good: tuple[int, ...] = (0,)) -> tuple[int, str]:
    """Exit code and output of the program; what it remarks is logged."""
    LOG.debug("gravcal %s", shlex.join(arguments))
    # Notebooks ask for colours, by these.
    plain = {name: value for name, value in os.environ.items() if name not in ("CLICOLOR_FORCE", "FORCE_COLOR")}
    command = [sys.executable, "-m", "gravcal", *arguments]
    done = subprocess.run(command, capture_output=True, check=False, env={**plain, "NO_COLOR": "1"})
    told = done.stderr.decode("utf-8", "replace")
    if done.returncode not in good:
        raise told_by_program(told, arguments)
    for remark in told.splitlines():
        LOG.info(remark)
    return done.returncode, done.stdout.decode("utf-8")
