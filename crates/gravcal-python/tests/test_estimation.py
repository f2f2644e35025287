"""`gravcal.estimation`: published answers, examples, and what one can get wrong."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from pathlib import Path
from typing import Any, Callable

import gravcal
import numpy as np
import pytest
from gravcal.estimation import Affine, Problem

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

# Misra1a of NIST's Statistical Reference Datasets.
MISRA_Y = [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78]
MISRA_X = [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0]
MISRA = {"b1": (2.3894212918e02, 2.7070075241e00), "b2": (5.5015643181e-04, 7.2668688436e-06)}
MISRA_SQUARES = 1.2455138894e-01


def misra(**how: Any) -> Problem:
    x, y = np.array(MISRA_X), np.array(MISRA_Y)
    problem = Problem()
    problem.add_block("b1", 500.0)
    problem.add_block("b2", 1e-4)
    problem.add_residual(lambda b1, b2: b1 * (1.0 - np.exp(-b2 * x)) - y, ["b1", "b2"], **how)
    return problem


def misra_slopes(b1: float, b2: float) -> tuple[Any, Any]:
    decay = np.exp(-b2 * np.array(MISRA_X))
    return 1.0 - decay, b1 * np.array(MISRA_X) * decay


def line(**how: Any) -> tuple[Problem, Any]:
    x = np.linspace(0.0, 1.0, 30)
    problem = Problem()
    problem.add_block("slope", 1.0, unit="V/m")
    problem.add_block("offset", 0.0, unit="V")
    y = 2.0 * x + 0.5 + 0.01 * np.sin(40.0 * x)
    problem.add_residual(lambda slope, offset: slope * x + offset - y, ["slope", "offset"], **how)
    return problem, (x, y)


@pytest.mark.parametrize("jacobian", [None, misra_slopes], ids=["differences", "jacobian"])
@pytest.mark.parametrize("solver", ["levenberg-marquardt", "dogleg"])
def test_certified_values_are_found(solver: str, jacobian: Any) -> None:
    solution = misra(jacobian=jacobian).solve(solver=solver)
    assert solution.verdict == "determined" and solution.degrees_of_freedom == 12
    for name, (value, std) in MISRA.items():
        found = solution[name]
        assert np.isclose(found.value, value, rtol=1e-6) and np.isclose(found.std, std, rtol=1e-5)
    assert np.isclose(2.0 * solution.cost, MISRA_SQUARES, rtol=1e-8)
    assert np.isclose((solution.residuals["residual 0"] ** 2).sum(), MISRA_SQUARES, rtol=1e-8)
    costs = np.array([one.cost for one in solution.iterations])
    assert len(costs) > 3 and (costs[1:] < costs[:-1] * (1.0 + 1e-9)).all()


def test_an_accelerometer_on_six_sides() -> None:
    import accelerometer

    solution = accelerometer.main()
    truth = {"gain": np.array([1.02, 0.99, 1.005]) / accelerometer.GRAVITY, "bias": np.array([0.01, -0.02, 0.005])}
    for block, values in truth.items():
        stds = np.array([solution[name].std for name in solution.names[block]])
        assert (abs(solution.value(block) - values) < 4.0 * stds).all()
        assert np.allclose(solution.value(block), solution.blocks[block])
    assert "gain.x" in solution.table and solution._repr_html_().startswith("<pre>determined")


def test_potentiometers_of_1976() -> None:
    import potentiometers

    # The scale that was published with the table (MIT joint 2).
    found = potentiometers.scale([(0.0, 3137.0), (-90.0, 2061.0), (-180.0, 1032.0)])
    assert found is not None and abs(found[0] / 0.0852676 - 1.0) < 0.005
    assert potentiometers.scale([(0.0, 3137.0), (-90.0, 2061.0)]) is None
    scales = potentiometers.main()
    assert not scales or sum(found is not None for found in scales.values()) > 5


def test_a_thermistor_with_a_wrong_reading() -> None:
    import thermistor

    solution, (kelvin, std) = thermistor.main()
    weights = solution.weights["thermometer"]
    assert weights[7] < 1e-6 and weights.argmin() == 7 and weights.sum() > 20
    truth = thermistor.temperature(np.array(thermistor.TRUTH), np.array([np.log(1e4)]))[0]
    assert abs(kelvin - truth) < 4.0 * std and 0.002 < std < 0.02


def test_what_the_readings_do_not_determine_is_named() -> None:
    x = np.linspace(0.0, 1.0, 20)
    problem = Problem()
    for name in "ab":
        problem.add_block(name, 1.0)
    problem.add_block("c", [0.0, 0.0], components=["used", "idle"])
    problem.add_residual(lambda a, b: (0.7 * a + 2.0 * b) * x - x, ["a", "b"], std=0.1)
    problem.add_residual(lambda c: c[:1] - 1.0, "c", std=0.1)
    solution = problem.solve()
    assert solution.verdict == "partly-determined"
    assert [str(one) for one in solution.undetermined] == ["1.00 c.idle", "1.00 a − 0.35 b"]
    assert solution.undetermined[1].terms == pytest.approx({"a": 1.0, "b": -0.35})
    for name in ("a", "b", "c.idle"):
        assert solution[name].value is None and solution[name].std is None and solution[name].why
    assert "1.00 a − 0.35 b" in str(solution["a"].why) and solution["c.idle"].why == "no residual depends on it"
    assert solution["c.used"].value == pytest.approx(1.0) and solution["c.used"].std == pytest.approx(0.1)
    assert solution.covariance is not None and solution.covariance.names == ("c.used",)
    assert np.isnan(solution.value("a")) and np.array_equal(np.isnan(solution.value("c")), [False, True])

    # A prior of one determines both.
    problem.add_prior("b", std=0.01)
    problem.add_prior("c", mean=[0.0, 3.0], std=[10.0, 1.0])
    solution = problem.solve()
    assert solution.verdict == "determined" and solution["b"].std == pytest.approx(0.01)
    assert solution["c.idle"].value == pytest.approx(3.0)


def test_held_blocks_keep_their_values() -> None:
    problem, (x, y) = line(std=0.1)
    other = Problem()
    other.add_block("slope", 1.0)
    other.add_block("offset", 0.25, held="measured apart")
    other.add_residual(lambda slope, offset: slope * x + offset - y, ["slope", "offset"], std=0.1)
    solution = other.solve()
    offset = solution["offset"]
    assert (offset.value, offset.std, offset.held) == (0.25, None, "measured apart") and solution.converged
    assert solution.covariance is not None and solution.covariance.names == ("slope",)
    assert solution["slope"].std < problem.solve()["slope"].std


def test_noise_is_stated_or_told_by_the_residuals() -> None:
    stated, relative = line(std=0.1)[0].solve(), line(std=0.1)[0].solve(noise="relative")
    estimated = line()[0].solve()
    ratio = relative["slope"].std / stated["slope"].std
    assert np.isclose(ratio**2, 2.0 * stated.cost / stated.degrees_of_freedom)
    assert np.isclose(estimated["slope"].std, relative["slope"].std, rtol=1e-6)
    # Student's intervals are wider than normal ones.
    for solution, factor in ((stated, 1.959964), (relative, 2.048407)):
        slope = solution["slope"]
        assert np.isclose((slope.interval[1] - slope.interval[0]) / slope.std / 2.0, factor, rtol=1e-5)
    problem, _ = line(std=0.1)
    problem.add_residual(lambda slope: slope - 2.0, "slope", name="unsaid")
    with pytest.raises(gravcal.InputError, match="`unsaid` states no noise and others do"):
        problem.solve()
    # A covariance that is diagonal is the same as standard deviations.
    same = line(covariance=0.01 * np.eye(30))[0].solve()
    assert np.isclose(same["slope"].std, stated["slope"].std, rtol=1e-9)


def test_nothing_left_to_tell_the_noise_leaves_no_standard_deviation() -> None:
    problem = Problem()
    problem.add_block("a", 1.0)
    problem.add_residual(lambda a: a - 3.0, "a")
    solution = problem.solve()
    assert solution["a"].value == pytest.approx(3.0) and solution["a"].std is None and solution.covariance is None
    assert "nothing is left to estimate the noise" in solution.notes[0]


def test_constraints_are_obeyed() -> None:
    problem, _ = line(std=0.01)
    problem.add_bound("offset", lower=0.8)
    problem.add_range(Affine({"slope": 1.0, "offset": 1.0}, -2.0), lower=0.0, upper=0.0, name="ends at 2")
    with pytest.raises(gravcal.InputError, match="the start breaks `bounds of offset`"):
        problem.solve()
    solution = problem.solve(start={"offset": 0.9, "slope": 1.1})
    assert solution["offset"].value == pytest.approx(0.8) and solution["slope"].value == pytest.approx(1.2)
    assert set(solution.active) == {"bounds of offset", "ends at 2"}

    problem = Problem()
    problem.add_block("v", [0.0, 0.0, 0.5], components="xyz")
    problem.add_residual(lambda v: v - [3.0, 0.0, 4.0], "v", std=0.1)
    problem.add_ball("v", [0.0, 0.0, 0.0], 1.0)
    assert problem.solve().value("v") == pytest.approx([0.6, 0.0, 0.8], abs=1e-6)

    problem = Problem()
    problem.add_block("v", [0.0, 0.0, 2.0], components="xyz", length=2.0)
    problem.add_residual(lambda v: v - [3.0, 0.0, 4.0], "v", std=0.1)
    solution = problem.solve()
    assert solution.value("v") == pytest.approx([1.2, 0.0, 1.6]) and solution.verdict == "determined"
    # Its length is known: the covariance has two dimensions.
    assert np.linalg.matrix_rank(solution.covariance.matrix, tol=1e-9) == 2

    problem = Problem()
    problem.add_block("v", [0.0, 0.0, 2.0], components="xyz")
    problem.add_residual(lambda v: v - [3.0, 0.0, 4.0], "v", std=0.1)
    problem.add_length("v", 2.0)
    assert problem.solve().value("v") == pytest.approx([1.2, 0.0, 1.6], rel=1e-6)

    problem = Problem()
    problem.add_block("v", [0.0, 0.0, 1.9], components="xyz")
    problem.add_residual(lambda v: v - [3.0, 0.0, 4.0], "v", std=0.1)
    problem.add_cone([{"v.x": 1.0}, {"v.y": 1.0}], {"v.z": 0.25}, name="steep")
    solution = problem.solve()
    # The nearest point of the cone: along (0.25, 0, 1).
    assert solution.value("v") == pytest.approx(np.array([0.25, 0.0, 1.0]) * 4.75 / 1.0625, rel=1e-6)
    assert list(solution.active) == ["steep"]


def test_what_a_residual_raises_ends_the_solve() -> None:
    calls = []

    def raising(a: float) -> Any:
        calls.append(a)
        if len(calls) > 3:
            raise KeyError("mine")
        return np.array([a - 2.0])

    problem = Problem()
    problem.add_block("a", 1.0)
    problem.add_residual(raising, "a")
    with pytest.raises(KeyError, match="mine"):
        problem.solve()
    assert len(calls) == 4, "nothing is asked after it"

    def interrupting(a: float) -> Any:
        calls.append(a)
        if len(calls) == 8:
            os.kill(os.getpid(), signal.SIGINT)
        return np.exp(np.array([a])) - 2.0

    problem = Problem()
    problem.add_block("a", 1.0)
    problem.add_residual(interrupting, "a")
    with pytest.raises(KeyboardInterrupt):
        # It would go on for long.
        problem.solve(cosine_tolerance=0.0, step_tolerance=0.0, cost_tolerance=0.0, max_iterations=10**9)


def test_a_solver_steps_back_from_where_there_is_no_value() -> None:
    refused = []

    def root(a: float) -> Any:
        if a < 0.0:
            refused.append(a)
            raise FloatingPointError("the root of a negative number")
        return np.array([np.sqrt(a) - 0.01, 0.01 * (a - 1e-4)])

    problem = Problem()
    problem.add_block("a", 9.0)
    problem.add_residual(root, "a", jacobian=lambda a: np.array([0.5 / np.sqrt(a), 0.01]))
    solution = problem.solve()
    assert solution["a"].value == pytest.approx(1e-4, rel=1e-6) and refused


def test_not_converging_is_an_answer_without_values() -> None:
    solution = misra().solve(max_iterations=1)
    assert solution.verdict == "failed" and not solution.converged and "1 iteration" in solution.termination
    assert solution["b1"].value is None and solution["b1"].why == "the solver did not converge"
    again = misra().solve(start=solution.blocks)
    assert again["b1"].value == pytest.approx(MISRA["b1"][0], rel=1e-6)


def test_solutions_are_values() -> None:
    solution = misra().solve()
    again = pickle.loads(pickle.dumps(solution))
    assert again.table == solution.table and again["b2"] == solution["b2"]
    pytest.importorskip("pandas")
    assert solution.to_pandas().loc["b1", "value"] == solution["b1"].value
    with pytest.raises(KeyError, match="there is no parameter `b3`; there is b1, b2"):
        solution["b3"]


WRONG: list[tuple[str, Callable[[Problem], Any], str]] = [
    ("a block twice", lambda p: p.add_block("a", 1.0), "there is a block `a` already"),
    ("text", lambda p: p.add_block("b", "one"), "the initial value of `b` is 'one'; expected numbers"),
    ("NaN", lambda p: p.add_block("b", [1.0, np.nan]), "expected finite numbers"),
    ("a matrix", lambda p: p.add_block("b", np.eye(2)), r"shape \(2, 2\); expected a number or a row"),
    ("components", lambda p: p.add_block("b", [1.0, 2.0], components=["x"]), "expected one name each"),
    ("no such block", lambda p: p.add_residual(lambda b: b, "b"), "there is no block `b`; there is a"),
    ("a block read twice", lambda p: p.add_residual(lambda a, b: a, ["a", "a"]), "reads a block twice"),
    ("empty", lambda p: p.add_residual(lambda a: np.zeros(0), "a"), "`residual 0` is empty"),
    ("no number", lambda p: p.add_residual(lambda a: np.array([1.0, np.nan]) * a, "a"), r"is nan at \[1\]"),
    ("no array", lambda p: p.add_residual(lambda a: object(), "a"), r"the function of `residual 0` returned is <object.*; expected numbers"),
    ("std of another shape", lambda p: p.add_residual(lambda a: np.ones(3) * a, "a", std=[1.0, 2.0]), "std of `residual 0` has shape"),
    ("both", lambda p: p.add_residual(lambda a: a, "a", std=1.0, covariance=[[1.0]]), "say one of them"),
    ("prior of nothing", lambda p: p.add_prior("a"), "how well is `a` known"),
    ("no such parameter", lambda p: p.add_range({"a.x": 1.0}, lower=0.0, name="r"), "no parameter `a.x`; there is a"),
    ("a negative std", lambda p: p.add_residual(lambda a: a, "a", std=-1.0), "must be positive"),
    ("no std", lambda p: p.add_residual(lambda a: np.ones(2) * a, "a", std=[1.0, 0.0]), "the std of `residual 0` is 0.0; it must be positive"),
    ("a prior without std", lambda p: p.add_prior("a", std=0.0), "the std of `prior of a` is 0.0"),
    ("a masked std", lambda p: p.add_residual(lambda a: np.ones(2) * a, "a", std=np.ma.masked_less([1.0, 2.0], 1.5)), "has masked entries"),
    ("an unknown loss", lambda p: p.add_residual(lambda a: a, "a", loss="welsch"), "unknown loss `welsch`; there is none, huber"),
    ("a width of nothing", lambda p: p.add_residual(lambda a: a, "a", width=2.0), "has a width and no loss"),
    ("no width", lambda p: p.add_residual(lambda a: a, "a", loss="huber", width=0), "the width of the loss of `residual 0` is 0"),
    ("a width as text", lambda p: p.add_residual(lambda a: a, "a", loss="huber", width="x"), "is 'x'; expected a positive number"),
    ("held without a reason", lambda p: p.add_block("b", 1.0, held=True), "held of `b` is True; expected text that says why"),
    ("no return", lambda p: p.add_residual(lambda a: None, "a"), "the function of `residual 0` returned None: is there no `return` in it"),
    ("no return of a jacobian", lambda p: (p.add_residual(lambda a: a, "a", jacobian=lambda a: None), p.solve()), "the jacobian of `residual 0` returned None"),
    ("single precision", lambda p: p.add_residual(lambda a: np.ones(3, np.float32) * np.float32(a), "a"), "float32, which is too coarse"),
    ("numbers as text", lambda p: p.add_residual(lambda a: np.array(["1.5"]), "a"), "holds <U3; expected numbers"),
    ("complex", lambda p: p.add_residual(lambda a: np.ones(3) * a + 0j, "a"), "holds complex128; expected numbers"),
    ("masked", lambda p: p.add_residual(lambda a: np.ma.masked_array([a, a], [False, True]), "a"), "has masked entries"),
    ("a complex start", lambda p: p.add_block("b", np.array([1j])), "expected numbers"),
    ("a start that is a list", lambda p: (p.add_residual(lambda a: a, "a"), p.solve(start=[1])), r"start is \[1\]; expected a mapping"),
    ("an unknown solver", lambda p: (p.add_residual(lambda a: a, "a"), p.solve(solver="simplex")), "unknown solver `simplex`"),
    ("an unknown option", lambda p: (p.add_residual(lambda a: a, "a"), p.solve(maxiter=4)), "unknown field `maxiter`, expected one of `max_iterations`"),
    ("an unread block", lambda p: (p.add_block("b", 1.0), p.add_residual(lambda a: a, "a"), p.solve()), "nothing reads the unknown `b`"),
    ("nothing read", lambda p: p.solve(), "no factors"),
    ("a wrong jacobian", lambda p: (p.add_residual(lambda a: a * np.ones(3), "a", jacobian=lambda a: 2.0 * np.ones(3)), p.solve()), r"at \[0\] by `a` is 2; differences give 1"),
    ("a jacobian of another shape", lambda p: (p.add_residual(lambda a: a * np.ones(3), "a", jacobian=lambda a: np.ones((3, 1))), p.solve()), r"shape \(3, 1\); expected \(3,\)"),
    ("a start of another shape", lambda p: (p.add_residual(lambda a: a, "a"), p.solve(start={"a": [1.0, 2.0]})), "the start of `a` has shape"),
    ("an unknown noise", lambda p: p.solve(noise="white"), "expected `stated` or `relative`"),
    ("constraints", lambda p: (p.add_residual(lambda a: a, "a"), p.add_bound("a", lower=0.0), p.solve(solver="dogleg")), "dogleg cannot take this problem"),
]


@pytest.mark.parametrize("_what,wrong,told", WRONG, ids=[wrong[0] for wrong in WRONG])
def test_mistakes_are_told(_what: str, wrong: Callable[[Problem], Any], told: str) -> None:
    problem = Problem()
    problem.add_block("a", 1.0)
    with pytest.raises(gravcal.InputError, match=told):
        wrong(problem)


def test_a_residual_keeps_its_shape() -> None:
    lengths = iter([3, 3, 3, 4, 4, 4, 4])
    problem = Problem()
    problem.add_block("a", 1.0)
    problem.add_residual(lambda a: a * np.ones(next(lengths)), "a")
    with pytest.raises(gravcal.InputError, match=r"has shape \(4,\), and had \(3,\)"):
        problem.solve()


def test_mistakes_name_the_residual() -> None:
    wrong: list[dict[str, Any]] = [{"std": 0.0}, {"loss": "welsch"}, {"width": 2.0}, {"loss": "huber", "width": -1.0}]
    for how in wrong:
        problem = Problem()
        problem.add_block("a", 1.0)
        with pytest.raises(gravcal.InputError) as raised:
            problem.add_residual(lambda a: a - 1.0, "a", name="mine", **how)
        assert raised.value.field == "mine"


def test_a_function_cannot_change_the_blocks() -> None:
    def changing(a: Any) -> Any:
        a *= 2.0
        return a - 3.0

    problem = Problem()
    problem.add_block("a", [1.0, 2.0])
    with pytest.raises(ValueError, match="read-only"):
        problem.add_residual(changing, "a")
    problem.add_residual(lambda a: a - 3.0, "a", jacobian=changing)
    with pytest.raises(ValueError, match="read-only"):
        problem.solve()


def test_a_function_may_return_the_same_array_each_time() -> None:
    x, y, values = np.array(MISRA_X), np.array(MISRA_Y), np.empty(len(MISRA_X))

    def kept(b1: float, b2: float) -> Any:
        return np.subtract(b1 * (1.0 - np.exp(-b2 * x)), y, out=values)

    problem = Problem()
    problem.add_block("b1", 500.0)
    problem.add_block("b2", 1e-4)
    problem.add_residual(kept, ["b1", "b2"])
    solution = problem.solve()
    assert solution == misra().solve() and solution["b1"].value == pytest.approx(MISRA["b1"][0], rel=1e-6)
    kept(1.0, 1.0)
    assert (solution.residuals["residual 0"] ** 2).sum() == pytest.approx(MISRA_SQUARES, rel=1e-8)


def test_what_is_given_is_copied() -> None:
    mean, std = np.array([1.0, 2.0]), np.array([0.1, 0.1])
    problem = Problem()
    problem.add_block("a", [0.0, 0.0])
    problem.add_prior("a", mean=mean, std=std)
    mean[:], std[:] = 7.0, 7.0
    solution = problem.solve()
    assert solution.value("a") == pytest.approx([1.0, 2.0]) and solution["a.0"].std == pytest.approx(0.1)


def test_options_may_be_numbers_of_numpy() -> None:
    assert not misra().solve(max_iterations=np.int64(1)).converged
    assert misra().solve(max_iterations=np.int64(30), cost_tolerance=np.float32(1e-9)).converged
