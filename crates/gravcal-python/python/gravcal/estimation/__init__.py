"""Least squares over named blocks of unknowns, for any sensor: residuals are vectorised functions of NumPy arrays.

>>> from gravcal.estimation import Problem
>>> problem = Problem()
>>> problem.add_block("gain", 1.0, unit="count/V")
>>> problem.add_block("bias", 0.0, unit="count")
>>> problem.add_residual(lambda gain, bias: gain * volts + bias - counts, ["gain", "bias"], std=0.5)
>>> solution = problem.solve()
>>> solution["gain"].value, solution["gain"].std

The problem holds, a solver minimises, and the solution says what the readings determine: what they do not has no value, and the
combinations without information are named. The estimate minimises

    ½ Σ ρ(‖Σ_f^(-1/2) r_f(x)‖²)

over the residuals `r_f` (a model less its readings) with noise covariances `Σ_f` and losses `ρ`, under constraints if there are any.
"""

from .constraints import Affine
from .problem import Problem
from .solution import Combination, Iteration, Parameter, Solution, WeakCombination

__all__ = ["Affine", "Combination", "Iteration", "Parameter", "Problem", "Solution", "WeakCombination"]
