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
    for _ in range(2):
        with pytest.raises(gravcal.InputError, match="the function of model `ripple` raised KeyError: 'mine'") as raised:
            session.calibrate("joint")
        assert raised.value.field == "ripple" and isinstance(raised.value.__cause__, KeyError)
        assert len(told) == 21, "nothing is asked after it"
        told.clear()


def nothing(x: Any, poses: Poses) -> Any:
    """A function whose `return` is forgotten."""
    wave(x, poses)


def writing(x: Any, poses: Poses) -> Any:
    position = poses.position
    position *= x[1]
    return x[0] * np.sin(position + x[2])


def changing(x: Any, poses: Poses) -> Any:
    x[2] += np.pi
    return wave(x, poses)


def dividing(x: Any, poses: Poses) -> Any:
    raise ZeroDivisionError("by nothing")


def test_a_function_may_return_the_same_array_each_time(rippled: dict[str, Any]) -> None:
    """One that writes its result into an array that it keeps, as of a loop that shall not allocate."""
    values: dict[int, Any] = {}

    def kept(x: Any, poses: Poses) -> Any:
        return np.multiply(x[0], np.sin(x[1] * poses.position + x[2]), out=values.setdefault(len(poses), np.empty(len(poses))))

    for jacobian in (None, wave_slopes):
        found = [
            gravcal.Session(**rippled, models=[SensorModel("ripple", function, WAVE, jacobian=jacobian)], joint=with_model({"kind": "ripple"}))
            .calibrate("joint").json
            for function in (kept, wave)
        ]
        assert found[0] == found[1]


def test_where_there_is_no_value_the_solver_steps_back(rippled: dict[str, Any]) -> None:
    refused: list[float] = []

    def limited(x: Any, poses: Poses) -> Any:
        if not refused and abs(x[1] - 6.0) > 1e-3:
            refused.append(x[1])
            raise FloatingPointError("beyond what it knows")
        return wave(x, poses)

    model = SensorModel("ripple", limited, WAVE)
    joint = gravcal.Session(**rippled, models=[model], joint=with_model({"kind": "ripple"})).calibrate("joint")["joint"]
    order = joint["joint2.ripple_order"]
    assert refused and order.value is not None and abs(order.value - 6.1) < 0.01


def test_models_are_values() -> None:
    model = SensorModel("ripple", wave, WAVE)
    assert model == SensorModel("ripple", wave, tuple(WAVE)) and hash(model) == hash(SensorModel("ripple", wave, WAVE))
    assert model != SensorModel("ripple", wave, WAVE[:2]) and len({model, model}) == 1


WRONG_PARAMETERS: list[tuple[dict[str, Any], str, str]] = [
    ({"limit": "x"}, "parameter `a` has the limit 'x'; expected a positive number of N·m", "limit"),
    *(({"limit": limit}, "has the limit .*; expected a positive number", "limit") for limit in (0, -1, np.nan, np.inf, None)),
    ({"limit": 1.0, "nominal": np.nan}, "has the nominal value nan; expected a number", "nominal"),
    ({"limit": 1.0, "unit": 1}, "the unit of a parameter is 1; expected text", "unit"),
]


@pytest.mark.parametrize(("said", "told", "field"), WRONG_PARAMETERS)
def test_wrong_parameters_are_told(said: dict[str, Any], told: str, field: str) -> None:
    with pytest.raises(gravcal.InputError, match=told) as raised:
        SensorParameter(**{"name": "a", "unit": "N·m", **said})
    assert raised.value.field == field
    assert SensorParameter("a", "N·m", np.float32(0.5)).limit == 0.5


WRONG: list[tuple[str, Callable[[], SensorModel], str]] = [
    ("a name of ours", lambda: SensorModel("coulomb-friction", wave, WAVE), "there is a sensor model `coulomb-friction` already"),
    ("another shape", lambda: SensorModel("ripple", lambda x, poses: x[0], WAVE), r"gives shape \(\); expected \(300,\)"),
    ("no numbers", lambda: SensorModel("ripple", lambda x, poses: "one", WAVE), "expected numbers"),
    ("numbers as text", lambda: SensorModel("ripple", lambda x, poses: np.full(len(poses), "1.5"), WAVE), "holds <U3; expected numbers"),
    ("complex", lambda: SensorModel("ripple", lambda x, poses: wave(x, poses) + 0j, WAVE), "holds complex128; expected numbers"),
    ("masked", lambda: SensorModel("ripple", lambda x, poses: np.ma.masked_less(wave(x, poses), 0.5), WAVE), "has masked entries"),
    ("single precision", lambda: SensorModel("ripple", lambda x, poses: wave(x, poses).astype(np.float32), WAVE), "float32, which is too coarse"),
    ("no return", lambda: SensorModel("ripple", nothing, WAVE), "returned None: is there no `return` in it"),
    ("no return of a jacobian", lambda: SensorModel("ripple", wave, WAVE, jacobian=nothing), "the jacobian of model `ripple` returned None"),
    ("NaN", lambda: SensorModel("ripple", lambda x, poses: wave(x, poses) * np.nan, WAVE), "of model `ripple` gives nan where the search starts"),
    ("no value", lambda: SensorModel("ripple", dividing, WAVE), "of model `ripple` raised ZeroDivisionError where the search starts .*by nothing"),
    ("positions that are changed", lambda: SensorModel("ripple", writing, WAVE), "raised ValueError: .*read-only"),
    ("parameters that are changed", lambda: SensorModel("ripple", changing, WAVE), "raised ValueError: .*read-only"),
    ("parameters that a jacobian changes", lambda: SensorModel("ripple", wave, WAVE, jacobian=changing), "jacobian .* raised ValueError: .*read-only"),
    ("a torque that is not declared", lambda: SensorModel("ripple", lambda x, poses: x[0] * poses.torque, WAVE), r'torque is read, but `reads` does not name it: say reads=\["torque"\]'),
    ("a time that is not declared", lambda: SensorModel("ripple", lambda x, poses: x[0] * poses.time, WAVE), "time is read, but `reads` does not name it"),
    ("entries of other poses", lambda: SensorModel("ripple", lambda x, poses: x[0] * np.ones(300) * poses.torque.sum(), WAVE, reads=["torque"]), "with any number of poses"),
    ("parameters that are text", lambda: SensorModel("ripple", wave, ["a"]), r"parameters\[0\] of model `ripple` is 'a'; expected a SensorParameter"),  # type: ignore[list-item]
    ("one parameter", lambda: SensorModel("ripple", wave, WAVE[0]), "expected a list of SensorParameter"),  # type: ignore[arg-type]
    ("reads that are text", lambda: SensorModel("ripple", wave, WAVE, reads="torque"), r'expected a list: reads=\["torque"\]'),  # type: ignore[arg-type]
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
