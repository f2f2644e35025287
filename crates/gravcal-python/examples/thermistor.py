"""A thermistor beside a reference thermometer: the three coefficients of Steinhart and Hart, though one reading is wrong.

    1/T = A + B ln R + C (ln R)³

Readings are drawn with known truth, so that errors can be told; yours are two arrays. The interpolated temperature has an uncertainty, too,
from the covariance of all three: they are strongly correlated, and none of them is of interest by itself.
"""

from __future__ import annotations

import numpy as np
from gravcal.estimation import Problem, Solution
from numpy.typing import NDArray

TRUTH = (1.129148e-3, 2.34125e-4, 8.76741e-8)
"""A, B and C of a thermistor of 10 kΩ at 25 °C."""
STD = 0.02
"""Of the reference thermometer, K."""

Floats = NDArray[np.float64]


def temperature(coefficients: Floats, logarithm: Floats) -> Floats:
    """K, from the logarithm of the resistance in Ω."""
    a, b, c = coefficients
    kelvin: Floats = 1.0 / (a + b * logarithm + c * logarithm**3)
    return kelvin


def slopes(coefficients: Floats, logarithm: Floats) -> Floats:
    """Of the temperature by the coefficients."""
    squared = temperature(coefficients, logarithm)[:, np.newaxis] ** 2
    return -squared * np.column_stack([np.ones_like(logarithm), logarithm, logarithm**3])


def main() -> tuple[Solution, Floats]:
    random = np.random.default_rng(1968)
    logarithm = np.linspace(np.log(1e3), np.log(4e4), 25)
    readings = temperature(np.array(TRUTH), logarithm) + STD * random.standard_normal(25)
    readings[7] += 3.0  # somebody opened the door

    problem = Problem()
    problem.add_block("coefficients", [1e-3, 2e-4, 1e-7], unit="1/K", components=["A", "B", "C"])
    problem.add_residual(
        lambda x: temperature(x, logarithm) - readings,
        "coefficients",
        std=STD,
        jacobian=lambda x: slopes(x, logarithm),
        loss="tukey",
        name="thermometer",
    )
    # From all readings alike to where the wrong one shows: Tukey's loss needs a start from which good readings look good.
    cauchy = Problem()
    cauchy.add_block("coefficients", [1e-3, 2e-4, 1e-7], unit="1/K", components=["A", "B", "C"])
    cauchy.add_residual(lambda x: temperature(x, logarithm) - readings, "coefficients", std=STD, loss="cauchy")
    solution = problem.solve(start=cauchy.solve().blocks)
    print(solution)
    print(f"the loss counts reading 7 with {solution.weights['thermometer'][7]:.3f}")

    # At 25 °C, from the covariance of all three.
    at = np.array([np.log(1e4)])
    found = np.asarray(solution.value("coefficients"))
    kelvin, slope = temperature(found, at)[0], slopes(found, at)[0]
    assert solution.covariance is not None
    std = float(np.sqrt(slope @ solution.covariance.matrix @ slope))
    print(f"10 kΩ: {kelvin - 273.15:.4f} ± {std:.4f} °C")
    return solution, np.array([kelvin, std])


if __name__ == "__main__":
    main()
