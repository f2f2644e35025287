"""Residuals of one's own."""

from __future__ import annotations

import pickle
from typing import Any

import gravcal
import numpy as np
import pytest
from gravcal import Observed, ResidualModel, SensorParameter

POINT = np.array([0.1, 0.05, 0.2])
AXIS = np.array([1.0, 0.0, 0.0])
GAUGE_ZERO, LEVEL_ZERO = 0.35, 0.02


def height(x: Any, observed: Observed) -> Any:
    return observed.point("link7", POINT)[:, 2] + x[0] - observed.column("reading")


def inclination(x: Any, observed: Observed) -> Any:
    down = observed.gravity_on("link5") @ AXIS / np.linalg.norm(observed.gravity)
    return np.arcsin(-down) + x[0] - observed.column("reading")


GAUGE = ResidualModel(
    "gauge", height, 2e-5, [SensorParameter("zero", "m", 0.001, 0.3, "reading = height + zero")], ["reading"], links=["link7"]
)
LEVEL = ResidualModel("level", inclination, 2e-4, [SensorParameter("zero", "rad", 0.01)], ["reading"], links=["link5"], gravity=True)
NAMED = [{"kind": "gauge", "columns": {"reading": "dial"}}, {"kind": "level", "columns": {"reading": "level"}}]


@pytest.fixture()
def observed(seven: dict[str, Any]) -> dict[str, Any]:
    """The experiment with a gauge and a level, which read what the joint estimate without them says, with noise."""
    calibration = gravcal.Session(**seven).calibrate("joint")
    parameters, gravity = calibration["joint"].parameters, np.array(calibration["joint"].gravity.vector)
    names = [f"joint{number}" for number in range(1, 8)]

    def value(name: str) -> float:
        told = parameters[name]
        return float(told.value if told.determined else told.nominal)

    gains = np.array([value(f"{name}.position_gain") for name in names])
    offsets = np.array([value(f"{name}.position_offset") for name in names])
    frames = [link_frames(coordinates) for coordinates in gains * seven["position"] + offsets]
    random = np.random.default_rng(3)
    dial = np.array([(frame["link7"] @ [*POINT, 1.0])[2] for frame in frames]) + GAUGE_ZERO + random.normal(0.0, 2e-5, len(frames))
    down = np.array([(frame["link5"][:3, :3].T @ gravity) @ AXIS for frame in frames]) / np.linalg.norm(gravity)
    level = np.arcsin(-down) + LEVEL_ZERO + random.normal(0.0, 2e-4, len(frames))
    dial[::7] = np.nan
    return {**seven, "columns": {"dial": dial, "level": level}}


def link_frames(coordinates: Any) -> dict[str, Any]:
    """By the robot's rows of Denavit and Hartenberg, beside the program's own kinematics."""
    import tomllib

    from conftest import ROOT

    with open(ROOT / "models/kuka-lbr-iiwa14/robot.toml", "rb") as file:
        robot = tomllib.load(file)
    assert robot["convention"] == "standard-dh"
    frame, frames = np.eye(4), {}
    for row, coordinate in zip(robot["joint"], coordinates):
        theta = coordinate + np.radians(row.get("theta_deg", 0.0))
        alpha, (s, c) = np.radians(row["alpha_deg"]), (np.sin(theta), np.cos(theta))
        sa, ca = np.sin(alpha), np.cos(alpha)
        a, d = row["a_m"], row["d_m"]
        frame = frame @ np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
        frames[row["link"]] = frame
    return frames


def test_unknowns_of_residuals_are_found(observed: dict[str, Any]) -> None:
    asked = []

    def counted(x: Any, rows: Observed) -> Any:
        asked.append(len(rows))
        return height(x, rows)

    gauge = ResidualModel("gauge", counted, 2e-5, GAUGE.parameters, ["reading"], links=["link7"])
    session = gravcal.Session(**observed, models=[gauge, LEVEL], residual=NAMED)
    joint = session.calibrate("joint")["joint"]
    rows = int(np.isfinite(observed["columns"]["dial"]).sum())
    assert asked and max(asked) == rows, "a call is one for all rows"
    for name, truth in (("gauge.zero", GAUGE_ZERO), ("level.zero", LEVEL_ZERO)):
        told = joint[name]
        # What is read lies at an estimate, which is off by what noise of torques makes of it.
        assert told.determined and abs(told.value - truth) < 5.0 * told.std + 1e-3, (name, told.value, told.std)
    assert joint["gauge.zero"].convention == "reading = height + zero"
    assert any(f"Residual gauge: {rows} rows" in note for note in joint.fields["notes"])
    without = gravcal.Session(**{key: own for key, own in observed.items() if key != "columns"}).calibrate("joint")["joint"]
    for name in ("joint4.position_gain", "joint4.position_offset"):
        assert joint[name].std < 0.2 * without[name].std
    with pytest.raises(gravcal.InputError):
        gravcal.Session(**observed, models=[LEVEL], residual=NAMED)


def test_what_a_function_raises_is_raised(observed: dict[str, Any]) -> None:
    def wrong(x: Any, rows: Observed) -> Any:
        raise LookupError("no such thing")

    gauge = ResidualModel("gauge", wrong, 2e-5, GAUGE.parameters, ["reading"], links=["link7"])
    with pytest.raises(gravcal.InputError, match="the function of residual `gauge` raised LookupError: no such thing") as raised:
        gravcal.Session(**observed, models=[gauge], residual=NAMED[:1]).calibrate("joint")
    assert raised.value.field == "gauge" and isinstance(raised.value.__cause__, LookupError)


def writing(x: Any, rows: Observed) -> Any:
    origin = rows.origin("link7")
    origin += 1.0
    return origin[:, 2] - rows.column("reading")


def turning(x: Any, rows: Observed) -> Any:
    rows.rotation("link7")[:, 2, 2] = 1.0
    return height(x, rows)


def reading(x: Any, rows: Observed) -> Any:
    rows.column("reading")[:] = 0.0
    return height(x, rows)


def changing(x: Any, rows: Observed) -> Any:
    x += 0.1
    return height(x, rows)


def falling(x: Any, rows: Observed) -> Any:
    rows.gravity[2] = 0.0
    return height(x, rows)


def moving(x: Any, rows: Observed) -> Any:
    rows.coordinates[:, 0] = 0.0
    return height(x, rows)


def nothing(x: Any, rows: Observed) -> Any:
    """A function whose `return` is forgotten."""
    height(x, rows)


def dividing(x: Any, rows: Observed) -> Any:
    raise ZeroDivisionError("by nothing")


def test_a_function_may_return_the_same_array_each_time(observed: dict[str, Any]) -> None:
    values: dict[int, Any] = {}

    def kept(x: Any, rows: Observed) -> Any:
        return np.add(height(x, rows), 0.0, out=values.setdefault(len(rows), np.empty(len(rows))))

    found = []
    for function in (kept, height):
        gauge = ResidualModel("gauge", function, 2e-5, GAUGE.parameters, ["reading"], links=["link7"])
        found.append(gravcal.Session(**observed, models=[gauge], residual=NAMED[:1]).calibrate("joint").json)
    assert found[0] == found[1]


def test_rows_are_where_columns_have_numbers(observed: dict[str, Any]) -> None:
    dial = observed["columns"]["dial"]
    masked = np.ma.masked_array(np.where(np.isnan(dial), 9.9, dial), np.isnan(dial))
    found = [
        gravcal.Session(**{**observed, "columns": {"dial": column}}, models=[GAUGE], residual=NAMED[:1]).calibrate("joint").json
        for column in (masked, dial)
    ]
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"std": 0.0}, "expected a positive number"),
        ({"links": ["link9"]}, "link9"),
        ({"function": lambda x, rows: np.zeros(3)}, "expected"),
        ({"std": np.full(300, 2e-5)}, "divide each row by its own and say std=1"),
        ({"function": lambda x, rows: np.zeros(300)}, r"gives shape \(300,\); expected \(1,\).*with any number of poses"),
        ({"function": lambda x, rows: height(x, rows) * np.nan}, "of residual `gauge` gives nan where the search starts"),
        ({"function": dividing}, "of residual `gauge` raised ZeroDivisionError where the search starts"),
        ({"function": nothing}, "returned None: is there no `return` in it"),
        ({"function": lambda x, rows: height(x, rows) + 0j}, "holds complex128; expected numbers"),
        ({"function": lambda x, rows: height(x, rows).astype(str)}, "holds <U32; expected numbers"),
        ({"function": lambda x, rows: np.ma.masked_array(height(x, rows), True)}, "has masked entries"),
        ({"function": lambda x, rows: height(x, rows).astype(np.float32)}, "float32, which is too coarse"),
        ({"function": lambda x, rows: rows.point("link2", POINT)[:, 0]}, r"`link2` is read, but `links` of the model names link7: say links=\["),
        ({"function": lambda x, rows: rows.column("dial")}, "`dial` is read, but `columns` of the model names reading"),
        ({"function": lambda x, rows: rows.gravity_on("link7")[:, 0]}, "gravity is read, but the model does not say so: say gravity=True"),
        *(({"function": function, "gravity": True}, "raised ValueError: .*read-only") for function in (writing, turning, reading, changing, falling, moving)),
        ({"columns": "reading"}, r'expected a list: columns=\["reading"\]'),
        ({"parameters": ["zero"]}, r"parameters\[0\] of model `gauge` is 'zero'; expected a SensorParameter"),
    ],
)
def test_what_is_wrong_is_said(change: dict[str, Any], told: str, observed: dict[str, Any]) -> None:
    said: dict[str, Any] = {
        "name": "gauge", "function": height, "std": 2e-5, "parameters": GAUGE.parameters, "columns": ["reading"], "links": ["link7"]
    }
    with pytest.raises(gravcal.InputError, match=told):
        gravcal.Session(**observed, models=[ResidualModel(**{**said, **change})], residual=NAMED[:1]).calibrate("joint")


def test_columns_have_an_entry_each_pose(observed: dict[str, Any]) -> None:
    with pytest.raises(gravcal.InputError, match="one each pose"):
        gravcal.Session(**{**observed, "columns": {"dial": np.zeros(3)}})


def test_a_model_is_copied() -> None:
    again = pickle.loads(pickle.dumps(GAUGE))
    assert again == GAUGE and again.links == ("link7",) and hash(again) == hash(GAUGE)
