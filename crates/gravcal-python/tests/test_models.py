"""Sensor models of one's own."""

from __future__ import annotations

import pickle
from typing import Any, Callable

import gravcal
import numpy as np
import pytest
from gravcal import Poses, SensorModel, SensorParameter

WAVE = [
    SensorParameter("ripple_amplitude", "N·m", 0.5, 1.0, "reading = ... + a sin(n position + p)", "record poses all around"),
    SensorParameter("ripple_order", "1/rad", 0.1, 6.0),
    SensorParameter("ripple_phase", "rad", 0.2),
]
TRUTH = {"ripple_amplitude": 2.0, "ripple_order": 6.1, "ripple_phase": 0.4}
FORMULA = {
    "kind": "formula",
    "adds": "a * sin(n * position + p)",
    "unknowns": {
        "a": {"unit": "N·m", "nominal": 1, "limit": 0.5},
        "n": {"unit": "1/rad", "nominal": 6, "limit": 0.1},
        "p": {"unit": "rad", "limit": 0.2},
    },
}


def wave(x: Any, poses: Poses) -> Any:
    return x[0] * np.sin(x[1] * poses.position + x[2])


def wave_slopes(x: Any, poses: Poses) -> Any:
    angle = x[1] * poses.position + x[2]
    return np.column_stack([np.sin(angle), x[0] * np.cos(angle) * poses.position, x[0] * np.cos(angle)])


def with_model(kind: Any) -> list[dict[str, Any]]:
    return [{"name": "joint2", "sensor_models": [kind]}]


@pytest.fixture()
def rippled(seven: dict[str, Any]) -> dict[str, Any]:
    """The experiment with a ripple in the torque sensor of joint 2."""
    torque = seven["torque"].copy()
    torque[:, 1] += 2.0 * np.sin(6.1 * seven["position"][:, 1] + 0.4)
    return {**seven, "torque": torque}


@pytest.mark.parametrize("jacobian", [None, wave_slopes], ids=["differences", "jacobian"])
def test_a_model_is_found_as_the_formula_is(jacobian: Any, rippled: dict[str, Any]) -> None:
    asked = []

    def counted(x: Any, poses: Poses) -> Any:
        asked.append(len(poses))
        return wave(x, poses)

    model = SensorModel("ripple", counted, WAVE, jacobian=jacobian)
    session = gravcal.Session(**rippled, models=[model], joint=with_model({"kind": "ripple"}))
    joint = session.calibrate("joint")["joint"]
    assert set(asked) == {300}, "every call is one for all poses"
    theirs = gravcal.Session(**rippled, joint=with_model(FORMULA)).calibrate("joint")["joint"]
    for (name, truth), formula in zip(TRUTH.items(), "anp"):
        ours, other = joint[f"joint2.{name}"], theirs[f"joint2.{formula}"]
        assert ours.determined and abs(ours.value - truth) < 4.0 * ours.std
        assert np.isclose(ours.value, other.value, rtol=1e-7) and np.isclose(ours.std, other.std, rtol=1e-5)
    assert joint["joint2.ripple_amplitude"].convention == "reading = ... + a sin(n position + p)"
    assert "ripple" in {one["model"] for one in joint.fields["sensor_models"]}
    # What it learnt is taken off the readings.
    _, torque = session.apply(
        session.calibrate("joint"), position=rippled["position"], torque=rippled["torque"], residual=True, nominal=True, load="weight-a"
    )
    carried = torque[np.array(rippled["load"]) == "weight-a", 1]
    assert len(carried) > 50 and carried.std() < 0.1


def test_a_model_that_reads_the_torque(seven: dict[str, Any]) -> None:
    """What ``c τ²`` adds to the reading of joint 2."""
    parameter = SensorParameter("curvature", "N·m/(N·m)²", 0.01)
    model = SensorModel(
        "bent", lambda x, poses: x[0] * poses.torque**2, [parameter], reads=["torque"], linear=True
    )
    # Few poses: it is called pose by pose.
    seven.update({name: seven[name][::5] for name in ("position", "torque", "load")})
    bent = dict(seven)
    gain, bias = (gravcal.Session(**seven).calibrate("joint")["joint"][f"joint2.torque_{it}"].value for it in ("gain", "bias"))
    assert gain is not None and bias is not None
    bent["torque"] = seven["torque"].copy()
    bent["torque"][:, 1] += 1e-3 * ((seven["torque"][:, 1] - bias) / gain) ** 2
    joint = gravcal.Session(**bent, models=[model], joint=with_model({"kind": "bent"})).calibrate("joint")["joint"]
    curvature = joint["joint2.curvature"]
    assert curvature.value is not None and curvature.std is not None
    assert abs(curvature.value - 1e-3) < 4.0 * curvature.std and curvature.std < 1e-4


def test_a_model_of_a_position_sensor(seven: dict[str, Any]) -> None:
    parameters = [SensorParameter("eccentric", "rad", 0.01)]
    model = SensorModel(
        "eccentric", lambda x, poses: x[0] * np.sin(poses.position), parameters, sensor="position", linear=True
    )
    session = gravcal.Session(**seven, models=[model], joint=with_model({"kind": "eccentric"}))
    eccentric = session.calibrate("joint")["joint"]["joint2.eccentric"]
    assert eccentric.value is not None and eccentric.std is not None and abs(eccentric.value) < 4.0 * eccentric.std


def test_sessions_with_models_can_be_pickled(rippled: dict[str, Any]) -> None:
    model = SensorModel("ripple", wave, WAVE)
    session = gravcal.Session(**rippled, models=[model], joint=with_model({"kind": "ripple"}))
    again = pickle.loads(pickle.dumps(session))
    assert again.calibrate("joint").json == session.calibrate("joint").json


def test_what_a_model_raises_ends_the_calibration(rippled: dict[str, Any]) -> None:
    told = []

    def raising(x: Any, poses: Poses) -> Any:
        told.append(x)
        if len(told) > 20:
            raise KeyError("mine")
        return wave(x, poses)

    model = SensorModel("ripple", raising, WAVE)
    session = gravcal.Session(**rippled, models=[model], joint=with_model({"kind": "ripple"}))
    with pytest.raises(KeyError, match="mine"):
        session.calibrate("joint")
    assert len(told) == 21, "nothing is asked after it"
    told.clear()
    with pytest.raises(KeyError, match="mine"):
        session.calibrate("joint")


WRONG: list[tuple[str, Callable[[], SensorModel], str]] = [
    ("a name of ours", lambda: SensorModel("coulomb-friction", wave, WAVE), "there is a sensor model `coulomb-friction` already"),
    ("another shape", lambda: SensorModel("ripple", lambda x, poses: x[0], WAVE), r"gives shape \(\); expected \(300,\)"),
    ("no numbers", lambda: SensorModel("ripple", lambda x, poses: "one", WAVE), "expected numbers"),
    ("a wrong jacobian", lambda: SensorModel("ripple", wave, WAVE, jacobian=lambda x, poses: 2.0 * wave_slopes(x, poses)), "differences give"),
    ("a jacobian of another shape", lambda: SensorModel("ripple", wave, WAVE, jacobian=lambda x, poses: x), r"expected \(300, 3\), poses by parameters"),
    ("a condition that is not read", lambda: SensorModel("ripple", wave, WAVE, reads=["temperature"]), "temperature"),
    ("an unknown condition", lambda: SensorModel("ripple", wave, WAVE, reads=["humidity"]), "reads `humidity`; there is torque, "),  # type: ignore[list-item]
    ("a torque of a position sensor", lambda: SensorModel("ripple", wave, WAVE, sensor="position", reads=["torque"]), "it reads no torque"),
    ("no parameters", lambda: SensorModel("ripple", wave, []), "has no parameters"),
]


@pytest.mark.parametrize("_what,model,told", WRONG, ids=[wrong[0] for wrong in WRONG])
def test_mistakes_are_told(_what: str, model: Callable[[], SensorModel], told: str, rippled: dict[str, Any]) -> None:
    with pytest.raises(gravcal.InputError, match=told):
        own = model()
        session = gravcal.Session(**rippled, models=[own], joint=with_model({"kind": own.name}))
        session.calibrate("joint")
