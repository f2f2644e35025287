"""What a solve answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np

from ..compared import Compared
from ..recording import Floats
from ..result import Covariance
from ..tabled import Tabled

__all__ = ["Combination", "Iteration", "Parameter", "Solution", "WeakCombination"]


@dataclass(frozen=True)
class Parameter:
    """One component of a block. What the readings do not determine has neither `value` nor `std`, but says `why`."""

    name: str
    unit: str
    value: Optional[float]
    std: Optional[float]
    interval: Optional[tuple[float, float]]
    """In which it lies with 95 %."""
    determined: bool
    held: Optional[str]
    """Why it is held at its value, where it is."""
    why: Optional[str]
    """Why it has no value."""


@dataclass(frozen=True)
class Combination:
    """Parameters that can change together without changing any residual."""

    text: str
    """Such as ``1.00 gain − 0.35 bias``: with the first go that much of the others."""
    terms: Mapping[str, float]

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class WeakCombination:
    """Parameters that hardly change any residual together."""

    combination: Combination
    times_worse: float
    """How many times its standard deviation, each parameter counted in what the readings make of it alone, exceeds that of the median."""


@dataclass(frozen=True)
class Iteration:
    """One step on the way."""

    cost: float
    cosine: float
    """Largest cosine between the residual and a column of the Jacobian: 0 where the gradient vanishes."""
    step: float
    """Relative length of the step."""


@dataclass(frozen=True, eq=False)
class Solution(Compared, Tabled):
    """The answer: parameters with what is known of them, and how it was found."""

    verdict: str
    """``determined``, ``partly-determined``, or ``failed`` where the solver did not converge."""
    termination: str
    """Why the solver ended."""
    parameters: Mapping[str, Parameter]
    """By name: a block of one number, else a component of a block such as ``bias.x``."""
    blocks: Mapping[str, Union[float, Floats]]
    """Where each block ended, whether it is determined or not: a start for another solve. Report `parameters` instead."""
    names: Mapping[str, tuple[str, ...]]
    """Of the parameters of each block."""
    covariance: Optional[Covariance]
    """Of what is determined and not held; `None` where there is none: `notes` say why."""
    undetermined: tuple[Combination, ...]
    weak: tuple[WeakCombination, ...]
    """What is known a thousand times worse than the median."""
    cost: float
    """½ Σ ρ of the whitened residuals."""
    degrees_of_freedom: int
    """Readings less the directions that they determine: without a loss, twice the cost is χ² with so many."""
    residuals: Mapping[str, Floats]
    """By name of the residual, in its unit and shape: model less reading."""
    weights: Mapping[str, Floats]
    """How much its loss counts each, from 0 to 1."""
    active: Mapping[str, float]
    """Constraints on which it leans, and by how much the cost would fall for each unit by which they give way."""
    iterations: tuple[Iteration, ...]
    singular_values: Floats
    """Of the whitened Jacobian with columns of unit length."""
    notes: tuple[str, ...]

    def __getitem__(self, name: str) -> Parameter:
        try:
            return self.parameters[name]
        except KeyError:
            raise KeyError(f"there is no parameter `{name}`; there is {', '.join(self.parameters)}") from None

    def value(self, block: str) -> Union[float, Floats]:
        """A block as residual functions are given it, with NaN for what the readings do not determine."""
        if block not in self.blocks:
            raise KeyError(f"there is no block `{block}`; there is {', '.join(self.blocks)}")
        own = [self.parameters[name].value for name in self.names[block]]
        values = np.array([np.nan if value is None else value for value in own])
        return float(values[0]) if self.names[block] == (block,) else values

    @property
    def converged(self) -> bool:
        return self.verdict != "failed"

    @property
    def table(self) -> str:
        """Parameters with standard deviations, and what is not determined."""
        width = max(len(name) for name in self.parameters)
        lines = [f"{self.verdict}: {self.termination}"]
        lines += [f"{name:{width}}  {_told(parameter)}" for name, parameter in self.parameters.items()]
        lines += [f"undetermined: {combination}" for combination in self.undetermined]
        lines += [f"weak, {weak.times_worse:.1e} times worse: {weak.combination}" for weak in self.weak]
        lines += [f"leans on: {name}" for name in self.active]
        return "\n".join([*lines, *self.notes])

    def to_pandas(self) -> Any:
        """A DataFrame with a row each parameter (needs pandas)."""
        import pandas

        rows = [
            {
                "value": one.value,
                "std": one.std,
                "low": one.interval[0] if one.interval else None,
                "high": one.interval[1] if one.interval else None,
                "unit": one.unit,
                "determined": one.determined,
                "why": one.why,
            }
            for one in self.parameters.values()
        ]
        return pandas.DataFrame(rows, index=pandas.Index(list(self.parameters), name="parameter"))


def _told(parameter: Parameter) -> str:
    if parameter.value is None:
        return f"undetermined: {parameter.why}"
    unit = f" {parameter.unit}" if parameter.unit else ""
    if parameter.held is not None:
        return f"{parameter.value:.8g}{unit}, held: {parameter.held}"
    std = "" if parameter.std is None else f" ± {parameter.std:.2g}"
    return f"{parameter.value:.8g}{std}{unit}"
