"""What one can get wrong, each told by an exception that says what to do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gravcal
import numpy as np
import pytest
from conftest import ROOT, SEVEN


def changed(array: Any, place: tuple[int, int], value: float) -> Any:
    array = array.copy()
    array[place] = value
    return array


WRONG: list[tuple[str, dict[str, Any], str, str]] = [
    ("too few columns", {"position": lambda a: a[:, :6]}, "position is 300 × 6; expected a row each pose", "position"),
    ("one dimension", {"torque": lambda a: a[:, 0]}, "torque is 300; expected a row each pose", "torque"),
    ("transposed", {"torque": lambda a: a.T}, "torque is 7 × 300", "torque"),
    ("other lengths", {"torque": lambda a: a[:-1]}, "torque has 299 rows and position 300", "torque"),
    ("NaN in positions", {"position": lambda a: changed(a, (4, 2), np.nan)}, r"position\[4, 2\] \(joint3\) is nan", "position"),
    ("NaN in torques", {"torque": lambda a: changed(a, (4, 2), np.nan)}, r"torque\[4, 2\] .* missing=\"nan\"", "torque"),
    ("infinite", {"torque": lambda a: changed(a, (0, 0), np.inf)}, r"torque\[0, 0\] \(joint1\) is inf", "torque"),
    ("text", {"position": lambda a: a.astype(str)}, "position holds <U32; expected numbers", "position"),
    ("complex", {"position": lambda a: a.astype(complex)}, "position holds complex128", "position"),
    ("objects", {"position": lambda a: a.astype(object)}, "position holds object", "position"),
    ("a unit of something else", {"torque_unit": lambda _: "rad"}, "the unit `rad` does not fit: expected a unit of torque readings", "readings.torque.unit"),
    ("too few units", {"position_unit": lambda _: ["rad"] * 6}, "expected 7 entries, one for each joint", "readings.position.unit"),
    ("an unknown load", {"load": lambda _: "weight-c"}, "weight-c", r"poses[0].load"),
    ("loads for other poses", {"load": lambda load: load[:-1]}, "load has 299 entries for 300 poses", "load"),
    ("an unknown section", {"lose": lambda _: {"kind": "huber"}}, "did you mean `loss`", "lose"),
    ("an unknown loss", {"loss": lambda _: {"kind": "hubert"}}, "hubert", "loss.kind"),
    ("gravity upwards of nothing", {"gravity": lambda _: -9.81}, "-9.81", "gravity.magnitude_m_per_s2"),
    ("what JSON cannot say", {"loss": lambda _: {"width": float("nan")}}, "what no session.toml can", ""),
    ("an unknown way of missing", {"missing": lambda _: "zero"}, "expected `refuse` or `nan`", "missing"),
    ("noise of another shape", {"torque_std": lambda _: np.ones((3, 7))}, "torque_std is 3 × 7, torque 300 × 7", "torque_std"),
    ("noise of nothing", {"torque_std": lambda _: 0.0}, "greater than 0", ""),
]


@pytest.mark.parametrize("_what,changes,told,field", WRONG, ids=[wrong[0] for wrong in WRONG])
def test_arrays(_what: str, changes: dict[str, Any], told: str, field: str, seven: dict[str, Any]) -> None:
    wrong = {**seven, **{name: change(seven.get(name)) for name, change in changes.items()}}
    with pytest.raises(gravcal.InputError, match=told) as raised:
        gravcal.Session(**wrong)
    assert raised.value.file is None and raised.value.line is None
    if field:
        assert raised.value.field == field


def test_units_must_be_stated(seven: dict[str, Any]) -> None:
    for name in ("position_unit", "torque_unit", "gravity"):
        with pytest.raises(TypeError, match=name):
            gravcal.Session(**{key: value for key, value in seven.items() if key != name})


def test_readings_may_be_missing_if_that_is_said(seven: dict[str, Any]) -> None:
    torque = changed(seven["torque"], (4, 2), np.nan)
    session = gravcal.Session(**{**seven, "torque": torque, "missing": "nan"})
    assert np.isnan(session.torque[4, 2]) and np.isnan(session.torque).sum() == 1


def test_a_joint_without_torque_sensor(seven: dict[str, Any]) -> None:
    torque = seven["torque"].copy()
    torque[:, 0] = np.nan
    session = gravcal.Session(**{**seven, "torque": torque, "missing": "nan"})
    assert np.isnan(session.torque[:, 0]).all()
    parameters = session.calibrate("joint")["joint"].parameters
    assert "joint1.torque_gain" not in parameters or not parameters["joint1.torque_gain"].asked


def test_frames_are_matched_by_name(seven: dict[str, Any]) -> None:
    pandas = pytest.importorskip("pandas")
    joints = list(seven["robot"].joints)
    frame = pandas.DataFrame(seven["position"], columns=joints)
    session = gravcal.Session(**{**seven, "position": frame[joints[::-1]]})
    assert (session.position == seven["position"]).all()
    with pytest.raises(gravcal.InputError, match="the columns of position are A1, .*; expected the joints joint1, "):
        gravcal.Session(**{**seven, "position": frame.rename(columns={"joint1": "A1"})})


def test_files_tell_file_line_and_field(tmp_path: Path) -> None:
    path = tmp_path / "session.toml"
    text = (SEVEN / "session.toml").read_text().replace("../../models", str(ROOT / "models"))
    path.write_text(text.replace("mass_kg = 5.0", "mass_kg = -5.0", 1))
    with pytest.raises(gravcal.InputError, match="-5 is not a mass") as raised:
        gravcal.Session.from_toml(path)
    line = 1 + path.read_text().splitlines().index("mass_kg = -5.0")
    error = raised.value
    assert (error.file, error.line, error.field) == (str(path), line, "load[0].mass_kg")
    for robot in (gravcal.Robot.from_toml, gravcal.Session.from_toml):
        with pytest.raises(gravcal.InputError, match="no such file"):
            robot(tmp_path / "absent.toml")


def test_names_that_do_not_exist(seven: dict[str, Any]) -> None:
    session = gravcal.Session(**seven)
    with pytest.raises(gravcal.InputError, match="unknown estimator `kalman`; there is: sequential, joint"):
        session.calibrate("kalman")
    with pytest.raises(gravcal.InputError, match="newton"):
        session.calibrate(solver="newton")


def test_tables_of_unequal_columns() -> None:
    with pytest.raises(gravcal.InputError, match="not of one length: q 2, y 3"):
        gravcal.Session.from_dict({}, {"poses": {"q": [0, 1], "y": [0, 1, 2]}})
    with pytest.raises(gravcal.InputError, match="missing field `gravity`"):
        gravcal.Session.from_dict({}, {"poses": {"q": [0, 1], "y": [0, 1]}})


@pytest.mark.parametrize("coloured", [False, True])
def test_commands_tell_file_line_and_field(coloured: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if coloured:
        monkeypatch.setenv("CLICOLOR_FORCE", "1")
        monkeypatch.setenv("FORCE_COLOR", "1")
    path = tmp_path / "simulation.toml"
    source = ROOT / "experiments/two-arms/simulation.toml"
    text = source.read_text().replace("../../models", str(ROOT / "models"))
    path.write_text(text + "\n[[load]]\nname = \"plate\"\nmass_kg = -3.0\nlink = \"link1\"\nposition_m = [0.0, 0.0, 0.0]\n")
    with pytest.raises(gravcal.InputError) as raised:
        gravcal.simulate(path, tmp_path / "session")
    line = 1 + path.read_text().splitlines().index("mass_kg = -3.0")
    error = raised.value
    assert (error.file, error.line) == (str(path), line) and str(error.field).endswith("mass_kg")

    for command in (gravcal.inspect, lambda path: gravcal.export(path, "csv")):
        absent = tmp_path / "absent.json"
        with pytest.raises(gravcal.InputError, match="(?i)no such file") as raised:
            command(absent)
        assert (raised.value.file, raised.value.line, raised.value.field) == (str(absent), None, None)

    with pytest.raises(gravcal.InputError, match="invalid value") as raised:
        gravcal.export(tmp_path / "absent.json", "cobol")
    assert raised.value.file is None
