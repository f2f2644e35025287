"""An accelerometer laid on each of its six sides: three gains and three biases, by the part of gravcal that knows no robot.

    reading = gain · a + bias,   a = ±9.80665 m/s² along the axis that is upright, 0 along the others

Run it anywhere: ``python crates/gravcal-python/examples/accelerometer.py``.
"""

from __future__ import annotations

import numpy as np
from gravcal.estimation import Problem, Solution

GRAVITY = 9.80665

# What the sensor reads on each side, g: gains 1.02, 0.99 and 1.005 of 1/9.80665, biases 0.01, -0.02 and 0.005, noise of 1 mg.
READINGS = np.array(
    [
        [1.0305, -0.0193, 0.0042],
        [-1.0094, -0.0207, 0.0061],
        [0.0113, 0.9702, 0.0044],
        [0.0096, -1.0112, 0.0057],
        [0.0089, -0.0195, 1.0091],
        [0.0108, -0.0204, -1.0008],
    ]
)
SENSED = GRAVITY * np.kron(np.eye(3), [[1.0], [-1.0]])
"""Specific force along the axes, m/s², a row each side."""


def main() -> Solution:
    problem = Problem()
    problem.add_block("gain", [0.1, 0.1, 0.1], unit="g/(m/s²)", components="xyz")
    problem.add_block("bias", [0.0, 0.0, 0.0], unit="g", components="xyz")
    problem.add_residual(lambda gain, bias: gain * SENSED + bias - READINGS, ["gain", "bias"], std=0.001)
    solution = problem.solve()
    print(solution)
    return solution


if __name__ == "__main__":
    main()
