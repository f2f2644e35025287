"""What one can get wrong, each told by an exception that says what to do."""

from __future__ import annotations

import shutil
import tempfile
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


RIPPLE = gravcal.SensorModel("ripple", lambda x, poses: x[0] * poses.position, [gravcal.SensorParameter("height", "N·m", 0.1)])

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
    ("a unit of something else", {"torque_unit": lambda _: "rad"}, "the unit `rad` does not fit: expected a unit of torque readings", "torque_unit"),
    ("too few units", {"position_unit": lambda _: ["rad"] * 6}, "expected 7 entries, one for each joint", "position_unit"),
    ("an unknown load", {"load": lambda _: "weight-c"}, "Session: load: there is no load `weight-c`", "load"),
    ("loads for other poses", {"load": lambda load: load[:-1]}, "load has 299 entries for 300 poses", "load"),
    ("an unknown section", {"lose": lambda _: {"kind": "huber"}}, "did you mean `loss`", "lose"),
    ("an unknown loss", {"loss": lambda _: {"kind": "hubert"}}, "hubert", "loss.kind"),
    ("gravity upwards of nothing", {"gravity": lambda _: -9.81}, "-9.81", "gravity.magnitude_m_per_s2"),
    ("what JSON cannot say", {"loss": lambda _: {"width": float("nan")}}, "loss.width is nan; expected a finite number", "loss.width"),
    ("an object", {"loss": lambda _: {"width": {1.0}}}, "loss.width is of type set; expected a number, text", "loss.width"),
    ("an unknown way of missing", {"missing": lambda _: "zero"}, "expected `refuse` or `nan`", "missing"),
    ("noise of another shape", {"torque_std": lambda _: np.ones((3, 7))}, "torque_std is 3 × 7, torque 300 × 7", "torque_std"),
    ("noise of nothing", {"torque_std": lambda _: 0.0}, "Session: torque_std: .*greater than 0", "torque_std"),
    ("noise of nothing in a cell", {"torque_std": lambda _: changed(np.ones((300, 7)), (5, 2), 0.0)}, r"torque_std\[5, 2\] \(joint3\) is 0.0", "torque_std"),
    ("noise that is NaN", {"torque_std": lambda _: [0.1, np.nan, *[0.1] * 5]}, r"torque_std\[1\] is nan; expected a finite number", "torque_std"),
    ("noise that is infinite", {"torque_std": lambda _: np.inf}, "torque_std is inf; expected a finite number", "torque_std"),
    ("noise in rows of other lengths", {"torque_std": lambda _: [[0.1], [0.1, 0.2]]}, "torque_std (is no table of numbers|.*expected)", "torque_std"),
    ("noise that is None", {"torque_std": lambda _: [0.1, None, *[0.1] * 5]}, r"torque_std\[1\] is None; expected numbers", "torque_std"),
    ("noise of positions", {"position_std": lambda _: "small"}, "position_std holds <U5; expected numbers", "position_std"),
    ("gravity that is NaN", {"gravity": lambda _: np.nan}, "gravity is nan; expected its strength", "gravity"),
    ("no gravity", {"gravity": lambda _: None}, "gravity is None; expected its strength", "gravity"),
    ("gravity as text", {"gravity": lambda _: "down"}, "gravity is 'down'; expected its strength", "gravity"),
    ("gravity as a vector", {"gravity": lambda _: [0, 0, -9.81]}, r"gravity is \[0, 0, -9.81\]; expected its strength", "gravity"),
    ("gravity in parts", {"gravity": lambda _: {"magnitude_m_per_s2": np.inf}}, "gravity.magnitude_m_per_s2 is inf; expected a finite", "gravity.magnitude_m_per_s2"),
    ("a path as robot", {"robot": lambda _: "arm3.toml"}, r'robot is "arm3.toml"; expected a Robot: Robot.from_toml\("arm3.toml"\)', "robot"),
    ("a URDF as robot", {"robot": lambda _: Path("arm.urdf")}, r'expected a Robot: Robot.from_urdf\("arm.urdf", base=', "robot"),
    ("a number as robot", {"robot": lambda _: 3}, "robot is of type int; expected a Robot", "robot"),
    ("a load without a name", {"load": lambda load: ["", *load[1:]]}, r"load\[0\] is ''; expected the name of a load, or None where nothing", "load"),
    ("a number as load", {"load": lambda _: 5}, "load is 5; expected the name of a load, or a name or None for each pose", "load"),
    ("a number among loads", {"load": lambda load: [5, *load[1:]]}, r"load\[0\] is 5; expected the name of a load", "load"),
    ("loads that are one", {"loads": lambda loads: loads[0]}, "expected a list with a dictionary for each load", "loads"),
    ("a mass that is NaN", {"loads": lambda loads: [{**loads[0], "mass_kg": np.nan}]}, r"loads\[0\].mass_kg is nan; expected a finite", "loads[0].mass_kg"),
    ("a mass below zero", {"loads": lambda loads: [{**loads[0], "mass_kg": -1.0}, loads[1]]}, r"Session: loads\[0\].mass_kg: -1 is not a mass", "loads[0].mass_kg"),
    ("rows of other lengths", {"position": lambda a: [*a[:-1].tolist(), [0.0]]}, "position (is no table of numbers; expected rows of one length|holds object)", "position"),
    ("no poses", {name: lambda a: a[:0] for name in ("position", "torque")}, "position has no rows: there are no poses", "position"),
    ("no torques", {"torque": lambda a: a * np.nan, "missing": lambda _: "nan"}, "torque holds no reading", "torque"),
    ("text as a column", {"columns": lambda _: {"a": ["x"] * 300}}, "column `a` holds <U1; expected numbers", "columns"),
    ("numbers as text", {"columns": lambda _: {"a": np.full(300, "1.5")}}, "column `a` holds <U3; expected numbers", "columns"),
    ("a complex column", {"columns": lambda _: {"a": np.full(300, 1j)}}, "column `a` holds complex128; expected numbers", "columns"),
    ("an infinite column", {"columns": lambda _: {"a": np.full(300, np.inf)}}, r"column `a`\[0\] is inf; expected a finite number, or NaN", "columns"),
    ("a list of columns", {"columns": lambda _: ["a"]}, "columns is of type list; expected a DataFrame, or a mapping", "columns"),
    ("a position as a column", {"columns": lambda _: {"position[joint3]": np.zeros(300)}}, r"column `position\[joint3\]` has a name of gravcal's own", "columns"),
    ("a torque as a column", {"columns": lambda _: {"torque[joint2]": np.zeros(300)}}, r"column `torque\[joint2\]` has a name of gravcal's own", "columns"),
    ("noise as a column", {"columns": lambda _: {"std[joint2]": np.zeros(300)}}, r"column `std\[joint2\]` has a name of gravcal's own", "columns"),
    ("readings that are said", {"readings": lambda _: {"torque": {"unit": "N"}}}, "`readings.torque.unit` is said by the argument `torque_unit`", "readings.torque.unit"),
    ("columns that are said", {"readings": lambda _: {"position": {"columns": ["a"]}}}, "is said by the argument `position`", "readings.position.columns"),
    ("noise that is said", {"readings": lambda _: {"torque": {"std": 0.1}}}, "is said by the argument `torque_std`", "readings.torque.std"),
    ("unknown readings", {"readings": lambda _: {"torque": {"lowset": 0.1}}}, "unknown field `lowset`", "readings.torque.lowset"),
    ("readings that are none", {"readings": lambda _: {"torque": 3}}, "readings.torque is 3; expected a dictionary", "readings.torque"),
    ("a number as model", {"models": lambda _: [3]}, r"models\[0\] is 3; expected a SensorModel or a ResidualModel", "models"),
    ("one model", {"models": lambda _: RIPPLE}, r"models is one model; expected a list: models=\[ripple\]", "models"),
]


@pytest.mark.parametrize("_what,changes,told,field", WRONG, ids=[wrong[0] for wrong in WRONG])
def test_arrays(_what: str, changes: dict[str, Any], told: str, field: str, seven: dict[str, Any]) -> None:
    wrong = {**seven, **{name: change(seven.get(name)) for name, change in changes.items()}}
    with pytest.raises(gravcal.InputError, match=told) as raised:
        gravcal.Session(**wrong)
    assert raised.value.file is None and raised.value.line is None
    if field:
        assert raised.value.field == field


def test_an_attribute_that_a_session_has_not_is_refused(seven: dict[str, Any]) -> None:
    session = gravcal.Session(**seven)
    with pytest.raises(AttributeError, match="torque_std"):
        session.torque_std = 5.0  # type: ignore[attr-defined]


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


def test_what_readings_say_is_added_to_other_arguments(seven: dict[str, Any]) -> None:
    session = gravcal.Session(**seven, readings={"torque": {"lowest": -15, "highest": 15}})
    # Readings at the ends of the range are left out.
    outside = np.abs(seven["torque"]) >= 15.0
    assert outside.any() and (np.isnan(session.torque) == outside).all()


def test_frames_are_paired_by_their_index(seven: dict[str, Any]) -> None:
    pandas = pytest.importorskip("pandas")
    joints = list(seven["robot"].joints)
    frames = {name: pandas.DataFrame(seven[name], columns=joints) for name in ("position", "torque")}
    shifted = {"position": frames["position"].iloc[1:], "torque": frames["torque"].iloc[:-1], "load": None}
    told = r"torque and position have different indices.* align them, as by torque.loc\[position.index\], or pass arrays"
    with pytest.raises(gravcal.InputError, match=told) as raised:
        gravcal.Session(**{**seven, **shifted})
    assert raised.value.field == "torque"
    gravcal.Session(**{**seven, **shifted, "torque": shifted["torque"].to_numpy()})
    session = gravcal.Session(**{**seven, **shifted, "torque": frames["torque"].iloc[1:]})
    assert (session.torque == seven["torque"][1:]).all()
    loads = pandas.Series(seven["load"], index=range(1, 301))
    with pytest.raises(gravcal.InputError, match="load and position have different indices") as raised:
        gravcal.Session(**{**seven, **frames, "load": loads})
    assert raised.value.field == "load"
    for field, given in (("torque_std", 0.1 * frames["torque"].iloc[::-1].abs()), ("columns", {"a": loads.isna() * 1.0})):
        with pytest.raises(gravcal.InputError, match="have different indices") as raised:
            gravcal.Session(**{**seven, **frames, field: given})
        assert raised.value.field == field
    with pytest.raises(gravcal.InputError, match="torque and position have different indices"):
        gravcal.Session(**seven).apply(None, position=frames["position"], torque=frames["torque"].iloc[::-1])  # type: ignore[arg-type]
    with pytest.raises(gravcal.InputError, match="column `y` of `a` and column `q` of `a` have different indices"):
        gravcal.Session.from_dict({}, {"a": {"q": pandas.Series([1.0, 2.0]), "y": pandas.Series([1.0, 2.0], index=[1, 0])}})


def test_pandas_says_what_is_missing(seven: dict[str, Any]) -> None:
    pandas = pytest.importorskip("pandas")
    joints = list(seven["robot"].joints)
    torque = pandas.DataFrame(seven["torque"], columns=joints).astype("Float64")
    torque.iloc[4, 2] = pandas.NA
    loads = pandas.Series(seven["load"])
    further = pandas.DataFrame({"a": seven["position"][:, 0], "b": pandas.array([1, None] * 150, dtype="Int64")})
    for load in (loads, loads.tolist(), [np.nan if name is None else name for name in seven["load"]], loads.fillna(np.nan)):
        session = gravcal.Session(**{**seven, "torque": torque, "missing": "nan", "load": load, "columns": further})
        assert session.loads == tuple(seven["load"])
        assert np.isnan(session.torque[4, 2]) and np.isnan(session.torque).sum() == 1
    with pytest.raises(gravcal.InputError, match=r"torque\[4, 2\] \(joint3\) is nan"):
        gravcal.Session(**{**seven, "torque": torque})


def test_standard_deviations_are_matched_by_name(seven: dict[str, Any]) -> None:
    pandas = pytest.importorskip("pandas")
    joints = list(seven["robot"].joints)
    stds = pandas.Series(seven["torque_std"], index=joints)
    for given in (stds, stds[joints[::-1]], stds.reset_index(drop=True), np.array(seven["torque_std"])):
        session = gravcal.Session(**{**seven, "torque_std": given})
        assert (session._native.std == seven["torque_std"]).all()
    with pytest.raises(gravcal.InputError, match="the index of torque_std is A1, .*; expected the joints joint1, ") as raised:
        gravcal.Session(**{**seven, "torque_std": stds.set_axis([f"A{place}" for place in range(1, 8)])})
    assert raised.value.field == "torque_std"


def test_masked_entries_of_columns_are_empty_cells(seven: dict[str, Any]) -> None:
    column = np.ma.masked_array(np.ones(300), np.arange(300) % 3 == 0)
    said: dict[str, Any] = {"columns": {"a": column}, "residual": [{"kind": "counted", "columns": {"a": "a"}}]}
    asked: list[int] = []

    def counted(x: Any, observed: gravcal.Observed) -> Any:
        asked.append(len(observed))
        return observed.column("a") - 1.0

    model = gravcal.ResidualModel("counted", counted, 1.0, columns=["a"])
    gravcal.Session(**seven, **said, models=[model]).calibrate("joint")
    assert max(asked) == 200
    masked = [np.ma.masked_array(row, np.arange(7) == 2) for row in seven["torque"]]
    session = gravcal.Session(**{**seven, "torque": masked, "missing": "nan"})
    assert np.isnan(session.torque[:, 2]).all() and np.isnan(session.torque).sum() == 300


def test_no_loads_may_be_none(seven: dict[str, Any]) -> None:
    arguments = {key: value for key, value in seven.items() if key != "load_distance"}
    assert set(gravcal.Session(**{**arguments, "load": None, "loads": None}).loads) == {None}


WRONG_DICTIONARIES: list[tuple[str, Any, Any, str, str]] = [
    ("text", "x", {}, "said is 'x'; expected a dictionary", "said"),
    ("a list of recordings", {}, [], "expected tables by the names", "recordings"),
    ("an array as a recording", {}, {"a": np.zeros((3, 2))}, "recording `a` is of type ndarray; expected a DataFrame", "a"),
    ("text in a column", {}, {"a": {"q": ["x"]}}, "column `q` of `a` holds <U1; expected numbers", "a"),
    ("NaN", {"gravity": {"magnitude_m_per_s2": np.nan}}, {}, "gravity.magnitude_m_per_s2 is nan", "gravity.magnitude_m_per_s2"),
    ("None in a list", {"poses": [None]}, {}, r"poses\[0\] is None; expected", "poses[0]"),
]


@pytest.mark.parametrize("_what,said,recordings,told,field", WRONG_DICTIONARIES, ids=[wrong[0] for wrong in WRONG_DICTIONARIES])
def test_dictionaries(_what: str, said: Any, recordings: Any, told: str, field: str) -> None:
    with pytest.raises(gravcal.InputError, match=told) as raised:
        gravcal.Session.from_dict(said, recordings)
    assert raised.value.field == field


def test_recordings_tell_file_and_line(tmp_path: Path) -> None:
    absent = tmp_path / "absent.csv"
    with pytest.raises(gravcal.InputError, match="there is no such file") as raised:
        gravcal.read(absent)
    assert (raised.value.file, raised.value.line) == (str(absent), None)
    path = tmp_path / "twice.csv"
    path.write_text("a,a\n1,2\n")
    with pytest.raises(gravcal.InputError, match="names column `a` twice") as raised:
        gravcal.read(path)
    assert (raised.value.file, raised.value.line) == (str(path), 1)


def test_a_session_tells_which_recording(tmp_path: Path) -> None:
    text = (SEVEN / "session.toml").read_text().replace("../../models", str(ROOT / "models"))
    (tmp_path / "session.toml").write_text(text)
    for path in SEVEN.glob("*.csv"):
        (tmp_path / path.name).write_text(path.read_text())
    lines = (tmp_path / "bare.csv").read_text().splitlines()
    (tmp_path / "bare.csv").write_text("\n".join([*lines[:4], "1,2", *lines[4:]]))
    with pytest.raises(gravcal.InputError) as raised:
        gravcal.Session.from_toml(tmp_path / "session.toml")
    assert (raised.value.file, raised.value.line) == (str(tmp_path / "bare.csv"), 5), str(raised.value)


def test_files_that_are_gone_are_not_told(
    calibrated: gravcal.Calibration, seven: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # What lies where temporary files lie is not taken for what the calibration was made from.
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    shutil.copytree(ROOT / "models", tmp_path / "models")

    def applied() -> Any:
        readings = {name: seven[name] for name in ("position", "torque")}
        return gravcal.Session(**seven).apply(calibrated, **readings, estimator="kalman")

    for work in (applied, lambda: gravcal.export(calibrated, "urdf")):
        with pytest.raises(gravcal.InputError, match="^the calibration: ") as raised:
            work()
        assert raised.value.file is None and str(tmp_path) not in str(raised.value)


def test_a_load_counts_only_for_residual_torques(calibrated: gravcal.Calibration, seven: dict[str, Any], tmp_path: Path) -> None:
    readings = {name: seven[name] for name in ("position", "torque")}
    for work in (
        lambda: gravcal.Session(**seven).apply(calibrated, **readings, load="typo"),
        lambda: gravcal.apply(calibrated, SEVEN / "bare.csv", tmp_path / "out.csv", load="typo"),
    ):
        with pytest.raises(gravcal.InputError, match="load is 'typo', which counts only with residual=True") as raised:
            work()
        assert raised.value.field == "load"


def test_paths_are_no_options(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for work in (gravcal.inspect, lambda path: gravcal.export(path, "csv"), lambda path: gravcal.simulate(path, "out")):
        with pytest.raises(gravcal.InputError, match="(?i)no such file") as raised:
            work("--help")
        assert raised.value.file == "./--help"
    Path("-bare.csv").write_text((SEVEN / "bare.csv").read_text())
    assert "joint1_torque_Nm" in str(gravcal.inspect("-bare.csv"))


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
