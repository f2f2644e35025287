"""Numbers from Python are the program's, to the last bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import gravcal
import numpy as np
import pytest
from conftest import SEVEN, program, sessions


@pytest.mark.parametrize("path", sessions(), ids=lambda path: path.parent.name)
def test_of_every_experiment(path: Path, tmp_path: Path) -> None:
    run = program("calibrate", path, "--quiet", "--output", tmp_path)
    if run.returncode == 2 and "no such" in run.stderr:
        pytest.skip("its recording is not in this checkout")
    result = gravcal.Session.from_toml(path).calibrate()
    assert (result.exit_code, result.json) == (run.returncode, (tmp_path / "calibration.json").read_text())
    assert result.table == (tmp_path / "table.txt").read_text()
    # The same results are there: saving them changes nothing.
    assert result.save(tmp_path) is False
    for name, estimator in result.items():
        file = next(one for one in json.loads(result.json)["estimators"] if one["name"] == name)
        assert [parameter.value for parameter in estimator.parameters.values()] == [
            one["value"] for one in file["parameters"]
        ]
        assert estimator.covariance.matrix.tolist() == file["covariance"]["matrix"]


def answers(result: gravcal.Calibration) -> list[Any]:
    """Everything but the places in files: a row of an array has no header above it."""
    answers: list[Any] = json.loads(result.json, object_pairs_hook=_without_places)["estimators"]
    return answers


def _without_places(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    return {key: value for key, value in pairs if key not in ("file", "line")}


@pytest.fixture(scope="module")
def from_files() -> list[Any]:
    return answers(gravcal.Session.from_toml(SEVEN / "session.toml").calibrate())


def test_from_arrays(calibrated: gravcal.Calibration, from_files: list[Any]) -> None:
    assert answers(calibrated) == from_files


@pytest.mark.parametrize("kind", ["fortran", "read-only", "strided", "list", "masked"])
def test_however_arrays_lie_in_memory(kind: str, seven: dict[str, Any], from_files: list[Any]) -> None:
    for name in ("position", "torque"):
        array = seven[name]
        if kind == "fortran":
            array = np.asfortranarray(array)
        elif kind == "read-only":
            array = array.copy()
            array.flags.writeable = False
        elif kind == "strided":
            array = np.repeat(array, 2, axis=0)[::2]
        elif kind == "list":
            array = array.tolist()
        else:
            array = np.ma.masked_array(array)
        seven[name] = array
    assert answers(gravcal.Session(**seven).calibrate()) == from_files


def test_single_precision_is_what_it_is(seven: dict[str, Any]) -> None:
    position, torque = (seven[name].astype(np.float32) for name in ("position", "torque"))
    session = gravcal.Session(**{**seven, "position": position, "torque": torque})
    assert (session.position == position.astype(np.float64)).all()
    assert (session.torque == torque.astype(np.float64)).all()


def test_from_tables_by_name() -> None:
    said = {
        "robot": str(SEVEN / "../../models/kuka-lbr-iiwa14/robot.toml"),
        "gravity": {"magnitude_m_per_s2": 9.80665, "hemisphere": [0, 0, -1]},
        "readings": {
            "position": {"columns": [f"joint{i}_position_rad" for i in range(1, 8)], "unit": "rad"},
            "torque": {"columns": [f"joint{i}_torque_Nm" for i in range(1, 8)], "unit": "N·m", "std": 0.03},
        },
        "poses": [{"file": "bare"}],
    }
    table = gravcal.read(SEVEN / "bare.csv")
    session = gravcal.Session.from_dict(said, {"bare": {name: table[name] for name in table.columns}})
    assert (session.position == table.cells[:, :7]).all() and (session.torque == table.cells[:, 7:]).all()
    assert session.files == (said["robot"],)


def test_applied_to_arrays_and_to_files(calibrated: gravcal.Calibration, seven: dict[str, Any], tmp_path: Path) -> None:
    session = gravcal.Session.from_toml(SEVEN / "session.toml")
    result = session.calibrate()
    result.save(tmp_path / "calibration")
    for residual in (False, True):
        output = tmp_path / f"{residual}.csv"
        gravcal.apply(
            tmp_path / "calibration/calibration.json", SEVEN / "bare.csv", output,
            session=SEVEN / "session.toml", residual=residual, nominal=True,
        )
        table = gravcal.read(output)
        position, torque = session.apply(
            result, position=seven["position"][:100], torque=seven["torque"][:100], residual=residual, nominal=True
        )
        assert (table.cells == np.hstack([position, torque])).all()
