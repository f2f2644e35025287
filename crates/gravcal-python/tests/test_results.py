"""What a result says, and what one can do with it."""

from __future__ import annotations

import copy
import json
import pickle
import sys
from pathlib import Path
from typing import Any

import gravcal
import numpy as np
import pytest
from conftest import ROOT, SEVEN, program


def test_parameters_have_values_or_reasons(calibrated: gravcal.Calibration) -> None:
    joint = calibrated["joint"]
    gain = joint["joint2.torque_gain"]
    assert gain.determined and gain.value is not None and gain.std is not None and gain.interval is not None
    assert gain.interval[0] < gain.value < gain.interval[1] and gain.unit == "N·m/(N·m)"
    assert gain.why is None and "torque_gain * torque" in gain.convention
    lacking = [parameter for parameter in joint.parameters.values() if not parameter.determined and parameter.asked]
    for parameter in lacking:
        assert parameter.value is None and parameter.why and parameter.cure, parameter.name
    assert {name for one in joint.undetermined for name in one.parameters} >= {parameter.name for parameter in lacking}
    # It has found no sweeps, and says so of each.
    for parameter in calibrated["sequential"].parameters.values():
        assert parameter.determined or not parameter.asked or (parameter.why and parameter.cure), parameter.name
    with pytest.raises(KeyError, match="there is no parameter `joint9.torque_gain`"):
        joint["joint9.torque_gain"]
    with pytest.raises(KeyError, match="estimator `recursive` did not run"):
        calibrated["recursive"]


def test_covariances_have_names(calibrated: gravcal.Calibration) -> None:
    covariance = calibrated["joint"].covariance
    gain = calibrated["joint"]["joint2.torque_gain"]
    part = covariance.of("joint2.torque_gain", "joint3.torque_gain")
    assert part.shape == (2, 2) and np.allclose(part, part.T)
    assert gain.std is not None and np.isclose(np.sqrt(part[0, 0]), gain.std, rtol=1e-9)
    with pytest.raises(KeyError, match="no covariance of elbow"):
        covariance.of("elbow")


def test_residuals_are_those_of_the_fit(calibrated: gravcal.Calibration, seven: dict[str, Any]) -> None:
    joint = calibrated["joint"]
    residuals = joint.residuals
    assert residuals.channels == seven["robot"].joints and set(residuals.units) == {"N·m"}
    assert len(residuals) == seven["torque"].size and residuals.pose.max() == len(seven["torque"]) - 1
    for fit in joint.fields["fit"]["joints"]:
        rms = np.sqrt(np.mean(residuals.of(fit["joint"]) ** 2))
        assert np.isclose(rms, fit["rms"], rtol=1e-9), fit["joint"]


def test_gravity_points_downwards(calibrated: gravcal.Calibration) -> None:
    gravity = calibrated["joint"].gravity
    assert gravity is not None and np.isclose(np.linalg.norm(gravity.vector), 9.80665)
    assert np.allclose(gravity.vector, [0, 0, -9.80665], atol=0.05)


def test_copies_keep_the_session_and_pickles_do_not(calibrated: gravcal.Calibration, tmp_path: Path) -> None:
    for place, again in enumerate((copy.copy(calibrated), copy.deepcopy(calibrated))):
        assert again.save(tmp_path / str(place)) is True
    with pytest.raises(gravcal.InputError, match="pickled without its session: save the original"):
        pickle.loads(pickle.dumps(calibrated)).save("nowhere")


def test_results_are_compared_by_what_they_hold(calibrated: gravcal.Calibration) -> None:
    joint, sequential = calibrated["joint"], calibrated["sequential"]
    again = copy.deepcopy(joint)
    assert again == joint and again.covariance == joint.covariance and again.residuals == joint.residuals
    assert joint != sequential and joint.covariance != sequential.covariance and joint.residuals != 3
    again.residuals.residual[0] += 1.0
    assert again != joint
    bare = gravcal.read(SEVEN / "bare.csv")
    assert bare == gravcal.read(SEVEN / "bare.csv") != gravcal.read(SEVEN / "weight-a.csv")


def test_an_estimators_result_is_told_in_a_line(calibrated: gravcal.Calibration) -> None:
    told = str(calibrated["joint"])
    known = sum(parameter.determined for parameter in calibrated["joint"].parameters.values())
    assert told == repr(calibrated["joint"]) and len(told) < 140
    assert told.startswith(f"<gravcal.EstimatorResult joint: partly-determined, {known} of ")


def test_the_package_tells_its_version() -> None:
    assert program("--version").stdout.split() == ["gravcal", gravcal.__version__]


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])
def test_everything_can_be_copied(copied: Any, calibrated: gravcal.Calibration, seven: dict[str, Any]) -> None:
    again = copied(calibrated)
    assert (again.json, again.table, again.page) == (calibrated.json, calibrated.table, calibrated.page)
    assert str(again) == str(calibrated) == calibrated.summary
    assert (again["joint"].residuals.residual == calibrated["joint"].residuals.residual).all()
    assert again == calibrated and again["joint"] == calibrated["joint"]
    assert copied(seven["robot"]).joints == seven["robot"].joints
    session = gravcal.Session(**seven)
    for one in (session, gravcal.Session.from_toml(SEVEN / "session.toml")):
        again = copied(one)
        assert (again.position == one.position).all() and again.loads == one.loads


def test_errors_can_be_pickled() -> None:
    error = gravcal.InputError("wrong", file="session.toml", line=3, field="load[1].mass_kg")
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.file, again.line, again.field) == ("wrong", "session.toml", 3, "load[1].mass_kg")


def test_notebooks_show_one_screen(calibrated: gravcal.Calibration, tmp_path: Path) -> None:
    shown = calibrated._repr_html_()
    assert "Calibration of" in shown and "What to do" in shown and shown.count("<") == 2, "names are escaped"
    result = gravcal.Session.from_toml(SEVEN / "session.toml").calibrate()
    printed = program("calibrate", SEVEN / "session.toml", "--output", tmp_path).stdout
    screen = [line for line in printed.splitlines() if not line.startswith("Results in")]
    assert str(result).replace(".table", "--full").splitlines() == screen and len(screen) <= 25
    assert ".table: all." in str(result) and len(result.table) > 2 * len(str(result))
    assert repr(calibrated).startswith("<gravcal.Calibration sequential: ")
    assert calibrated.page.startswith("<!DOCTYPE html>")


def test_the_report_opens_in_a_browser(calibrated: gravcal.Calibration, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []

    def browse(url: str) -> bool:
        opened.append(url)
        return len(opened) == 1

    monkeypatch.setattr("webbrowser.open", browse)
    shown = calibrated.show()
    assert opened[0] == f"file://{shown}"
    assert opened[0].startswith("file:///") and Path(opened[0][len("file://") :]).read_text() == calibrated.page
    # A script goes on without a browser.
    with pytest.warns(UserWarning, match="there is no browser to show .*report.html; open it elsewhere"):
        shown = calibrated.show()
    assert shown is not None and Path(shown).read_text() == calibrated.page
    with pytest.raises(gravcal.InputError, match="not in `paper`"):
        calibrated.show("paper")  # type: ignore[arg-type]


def test_residuals_show_in_rerun(calibrated: gravcal.Calibration, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "rerun", None)
        with pytest.raises(gravcal.GravcalError, match="pip install rerun-sdk"):
            calibrated.show("rerun")
    rerun = pytest.importorskip("rerun")
    rerun.init("test")
    rerun.save(tmp_path / "shown.rrd")
    calibrated.show("rerun")
    rerun.disconnect()
    assert (tmp_path / "shown.rrd").stat().st_size > 10_000


def test_saved_results_are_those_of_the_program(calibrated: gravcal.Calibration, tmp_path: Path) -> None:
    assert calibrated.save(tmp_path) is True
    assert {path.name for path in tmp_path.iterdir()} == {"calibration.json", "table.txt", "report.html", "timing.json"}
    assert (tmp_path / "calibration.json").read_text() == calibrated.json
    (tmp_path / "calibration.json").write_text("{}")
    with pytest.raises(gravcal.InputError, match="other results are there already"):
        calibrated.save(tmp_path)
    assert calibrated.save(tmp_path, overwrite=True) is True


def test_tables_for_pandas(calibrated: gravcal.Calibration) -> None:
    pytest.importorskip("pandas")
    table = calibrated["joint"].to_pandas()
    assert table.loc["joint2.torque_gain", "value"] == calibrated["joint"]["joint2.torque_gain"].value
    residuals = calibrated["joint"].residuals.to_pandas()
    assert len(residuals) == len(calibrated["joint"].residuals) and set(residuals.channel) == set(table.index.str.split(".").str[0]) & set(residuals.channel)


def test_check_tells_before_any_solve(seven: dict[str, Any]) -> None:
    check = gravcal.Session(**seven).check()
    assert isinstance(check.complete, bool) and "joint2.torque_gain" in json.dumps(dict(check.fields))
    assert "kuka" in str(check) and check._repr_html_().startswith("<pre>")


def test_other_commands_work_on_files_and_results(calibrated: gravcal.Calibration, tmp_path: Path) -> None:
    path = gravcal.simulate(ROOT / "experiments/two-arms/simulation.toml", tmp_path / "arms", trial=3)
    session = gravcal.Session.from_toml(path)
    assert len(session) > 50
    assert "joint2" in gravcal.export(calibrated, "csv", nominal=True)
    comparison = gravcal.compare(calibrated, calibrated)
    assert comparison.moved is False and comparison.fields
    inspection = gravcal.inspect(SEVEN / "bare.csv")
    assert "joint1_torque_Nm" in str(inspection) and "joint1_torque_Nm" in json.dumps(dict(inspection.fields))
    with pytest.raises(gravcal.InputError, match="no such file"):
        gravcal.inspect(tmp_path / "absent.csv")


def test_studies_are_run(tmp_path: Path) -> None:
    simulation = ROOT / "experiments/sarcos-shoulder/simulation.toml"
    path = tmp_path / "study.toml"
    path.write_text(f"""simulation = '{simulation}'
trials = 6
estimators = ["sequential", "joint"]
[[vary]]
name = "noise"
unit = "count"
field = "torque.std"
values = [0.2, 0.8]
""")
    study = gravcal.study(path, tmp_path / "results", threads=1)
    assert study.table == (tmp_path / "results/report.txt").read_text() == str(study)
    gains = [one for one in study.measures if one["quantity"] == "joint3.torque_gain"]
    assert [(one["noise"], one["estimator"]) for one in gains] == [(n, e) for n in (0.2, 0.8) for e in ("sequential", "joint")]
    by_steps, jointly = gains[:2]
    assert by_steps["rms"] is None and isinstance(jointly["rms"], float) and jointly["trials"] == 6.0
    pytest.importorskip("pandas")
    assert len(study.to_pandas()) == len(study.measures)
    path.write_text(path.read_text().replace("torque.std", "torque.standard"))
    with pytest.raises(gravcal.InputError, match="standard") as raised:
        gravcal.study(path, tmp_path / "others")
    assert raised.value.file is not None
