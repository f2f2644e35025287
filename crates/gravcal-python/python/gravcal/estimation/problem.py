"""A problem: blocks, residuals, constraints."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Callable, Literal, Optional, Union

import numpy as np

from .. import _native
from ..arrays import floats
from ..errors import InputError
from ..forked import use_threads
from ..recording import Floats, Progress
from ..result import Covariance
from ..said import plain
from .constraints import Affine, Cone, Length, PlacedAffine, Range
from .residual import BlockLayout, Residual
from .solution import Combination, Iteration, Parameter, Solution, WeakCombination

__all__ = ["Problem"]

Function = Callable[..., Any]


@dataclass(frozen=True)
class Block:
    """A named group of unknowns, as the solver takes it."""

    name: str
    initial: Floats
    unit: str
    components: list[str]
    held: Optional[str]
    linear: bool
    length: Optional[float]
    scale: Floats

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(f"{self.name}.{component}" if component else self.name for component in self.components)


class Problem:
    """Nonlinear least squares over named blocks.

    Add blocks, then residuals of them, then `solve`. Problems can be solved again, from other starts and with other solvers.
    """

    def __init__(self) -> None:
        self._blocks: dict[str, Block] = {}
        self._residuals: dict[str, Residual] = {}
        self._constraints: dict[str, Union[Range, Cone, Length]] = {}

    def add_block(
        self,
        name: str,
        initial: Any,
        *,
        unit: str = "",
        components: Optional[Sequence[str]] = None,
        scale: Any = None,
        held: Optional[str] = None,
        linear: bool = False,
        length: Optional[float] = None,
    ) -> None:
        """Adds unknowns: a number, or several of one unit, with where the search starts.

        Residual functions are given a float, or an array of one dimension. `components` name the numbers of an array (else 0, 1, ...).
        `scale` is what a change of a number is measured by where derivatives come from differences: without it the initial value, or 1 where
        that is 0. `held` says why the block keeps its initial value. `linear`: all residuals are affine in all blocks that are marked so, for
        the solver ``variable-projection``. `length`: a vector of three numbers that keeps its length.
        """
        if name in self._blocks:
            raise InputError(f"there is a block `{name}` already", field=name)
        values = _floats(f"initial value of `{name}`", initial)
        if values.ndim > 1 or values.size == 0:
            told = f"the initial value of `{name}` has shape {values.shape}; expected a number or a row of numbers"
            raise InputError(told, field=name)
        if values.ndim == 0:
            if components is not None:
                raise InputError(f"`{name}` is a number: it has no components", field=name)
            names = [""]
        else:
            names = [str(place) for place in range(len(values))] if components is None else list(components)
        if len(names) != values.size or len(set(names)) != len(names):
            told = f"`{name}` has {values.size} numbers and the components {', '.join(names)}; expected one name each"
            raise InputError(told, field=name)
        if not (held is None or (isinstance(held, str) and held)):
            raise InputError(f"held of `{name}` is {held!r}; expected text that says why it keeps its initial value", field=name)
        values = np.atleast_1d(values).copy()
        typical = np.abs(values) if scale is None else np.abs(_floats(f"scale of `{name}`", scale))
        try:
            typical = np.broadcast_to(typical, values.shape)
        except ValueError:
            told = f"the scale of `{name}` has shape {typical.shape}; expected one number, or one each component"
            raise InputError(told, field=name) from None
        typical = np.where(typical > 0.0, typical, 1.0)
        block = Block(name, values, unit, names, held, linear, length, typical)
        taken = {parameter for other in self._blocks.values() for parameter in other.parameters}
        twice = taken.intersection(block.parameters)
        if twice:
            raise InputError(f"two parameters would be named `{min(twice)}`", field=name)
        self._blocks[name] = block

    def add_residual(
        self,
        function: Function,
        blocks: Union[str, Sequence[str]],
        *,
        std: Any = None,
        covariance: Any = None,
        jacobian: Optional[Function] = None,
        loss: Literal["none", "huber", "cauchy", "tukey", "geman-mcclure"] = "none",
        width: Optional[float] = None,
        name: Optional[str] = None,
    ) -> None:
        """Adds residuals: a model less its readings, in the unit of the readings.

        `function` is called with the values of `blocks`, in that order, and returns an array of any shape, the same shape always. Arrays
        that it is given cannot be written into. It may be called from several threads, one at a time. Where it raises an `ArithmeticError`
        or gives what is not finite, the solver shortens its step; all else that it raises ends the solve.

        `jacobian` is called alike and returns one array for each block, with the shape of the residual and behind it a column for each
        number of the block (no such axis for a block that is a number). It is compared with differences before each solve. Without it,
        derivatives are central differences.

        `std`: standard deviation of the readings, one for all or one each; or `covariance`, of all readings of this residual. Without
        either, in no residual of the problem, the noise is taken for equal and its size is told by the residuals.

        `loss` limits what outliers count, by reading where the noise is independent; `width`: beyond how many standard deviations, without
        which it is as efficient as 95 % of least squares.
        """
        name = name if name is not None else f"residual {len(self._residuals)}"
        if name in self._residuals:
            raise InputError(f"there is a residual `{name}` already", field=name)
        names = [blocks] if isinstance(blocks, str) else list(blocks)
        places = list(self._blocks)
        for block in names:
            self._block(block)
        layout = BlockLayout.of([self._blocks[block] for block in names])
        residual = Residual.of(
            name, function, jacobian, layout, [places.index(block) for block in names], loss=loss, width=width
        )
        residual = residual.tried(np.concatenate([self._blocks[block].initial for block in names]))
        self._residuals[name] = residual.with_noise(std, covariance)

    def add_prior(
        self, block: str, *, std: Any = None, covariance: Any = None, mean: Any = None, name: Optional[str] = None
    ) -> None:
        """What is known of a block beforehand: its mean (else its initial value), and how well."""
        own = self._block(block)
        if std is None and covariance is None:
            raise InputError(f"how well is `{block}` known? Say std or covariance", field=block)
        centre = own.initial if mean is None else np.atleast_1d(_floats(f"mean of `{block}`", mean)).copy()
        if centre.shape != own.initial.shape:
            told = f"the mean of `{block}` has shape {centre.shape}; expected {own.initial.shape}"
            raise InputError(told, field=block)
        alone = own.components == [""]
        slopes = np.ones(1) if alone else np.eye(len(centre))
        self.add_residual(
            lambda x: np.atleast_1d(x) - centre,
            block,
            std=std,
            covariance=covariance,
            jacobian=lambda _x: slopes,
            name=name if name is not None else f"prior of {block}",
        )

    def add_bound(
        self, block: str, *, lower: float = -math.inf, upper: float = math.inf, name: Optional[str] = None
    ) -> None:
        """Bounds on a parameter, or on every number of a block."""
        names = self._blocks[block].parameters if block in self._blocks else (block,)
        for parameter in names:
            own = (f"{name}: {parameter}" if len(names) > 1 else name) if name else f"bounds of {parameter}"
            self.add_range(Affine({parameter: 1.0}), lower=lower, upper=upper, name=own)

    def add_range(
        self,
        function: Union[Affine, Mapping[str, float]],
        *,
        lower: float = -math.inf,
        upper: float = math.inf,
        name: str,
    ) -> None:
        """``lower <= function <= upper``; both may be equal."""
        self._constrain(Range(name, self._placed(function), float(lower), float(upper)))

    def add_cone(
        self,
        norm_of: Sequence[Union[Affine, Mapping[str, float]]],
        at_most: Union[Affine, Mapping[str, float]],
        *,
        name: str,
    ) -> None:
        """The length of the vector `norm_of` is at most `at_most`."""
        self._constrain(Cone(name, [self._placed(part) for part in norm_of], self._placed(at_most)))

    def add_ball(self, block: str, centre: Any, radius: float, *, name: Optional[str] = None) -> None:
        """A block lies within `radius` of `centre`."""
        own, middle = self._block(block), np.atleast_1d(_floats(f"centre of `{block}`", centre))
        if middle.shape != own.initial.shape:
            told = f"the centre of `{block}` has shape {middle.shape}; expected {own.initial.shape}"
            raise InputError(told, field=block)
        parts = [Affine({parameter: 1.0}, -float(value)) for parameter, value in zip(own.parameters, middle)]
        self.add_cone(parts, Affine(constant=float(radius)), name=name if name is not None else f"ball of {block}")

    def add_length(self, block: str, length: float, *, name: Optional[str] = None) -> None:
        """A block has this length, as a constraint; without a solver for constraints: `length` of `add_block`."""
        self._block(block)
        own = name if name is not None else f"length of {block}"
        self._constrain(Length(own, list(self._blocks).index(block), float(length)))

    def check_jacobians(self) -> None:
        """Compares the derivatives that are given with differences, at the initial values. Raises `InputError`."""
        self._check_jacobians(self._blocks)

    def solve(
        self,
        *,
        start: Optional[Mapping[str, Any]] = None,
        solver: Optional[str] = None,
        noise: Optional[Literal["stated", "relative"]] = None,
        check_jacobians: bool = True,
        progress: Progress = None,
        **options: Any,
    ) -> Solution:
        """Minimises, and judges what was found.

        `start` replaces initial values, such as `Solution.blocks` of another solve. `solver`: ``levenberg-marquardt``, the default without
        constraints; ``clarabel``, the default with; ``gauss-newton``, ``dogleg``, ``variable-projection``. `options` are the solver's, such as
        ``max_iterations=200``.

        `noise`: whether standard deviations are ``stated``, or ``relative``: only their ratios are known, and the residuals tell the size.
        Without it ``stated`` where every residual states them, and ``relative`` where none does.

        `progress` is called with each iteration in a few words. Ctrl-C stops after the current one. Raises `InputError`, and what a residual
        function raises.
        """
        use_threads()
        blocks = self._started({} if start is None else start)
        relative = self._relative(noise)
        if check_jacobians:
            self._check_jacobians(blocks)
        try:
            said = json.dumps(plain(options), allow_nan=False)
        except (TypeError, ValueError) as error:
            raise InputError(f"an option of the solver is no number, truth or text: {error}") from None
        name = solver if solver is not None else ("clarabel" if self._constraints else "levenberg-marquardt")
        residuals, constraints = list(self._residuals.values()), list(self._constraints.values())
        found = _native.estimate(list(blocks.values()), residuals, constraints, name, said, relative, progress)
        return self._solution(blocks, found, name)

    def __repr__(self) -> str:
        return f"<gravcal.estimation.Problem of {', '.join(self._blocks)}: {', '.join(self._residuals)}>"

    def _block(self, name: str) -> Block:
        try:
            return self._blocks[name]
        except KeyError:
            told = f"there is no block `{name}`; there is {', '.join(self._blocks) or 'none yet'}"
            raise InputError(told, field=name) from None

    def _constrain(self, constraint: Union[Range, Cone, Length]) -> None:
        if constraint.name in self._constraints:
            raise InputError(f"there is a constraint `{constraint.name}` already", field=constraint.name)
        self._constraints[constraint.name] = constraint

    def _placed(self, function: Union[Affine, Mapping[str, float]]) -> PlacedAffine:
        affine = function if isinstance(function, Affine) else Affine(function)
        places = {
            parameter: (block, component)
            for block, own in enumerate(self._blocks.values())
            for component, parameter in enumerate(own.parameters)
        }
        unknown = [name for name in affine.terms if name not in places]
        if unknown:
            raise InputError(f"there is no parameter `{unknown[0]}`; there is {', '.join(places)}", field=unknown[0])
        return PlacedAffine([(*places[name], float(c)) for name, c in affine.terms.items()], float(affine.constant))

    def _started(self, start: Mapping[str, Any]) -> dict[str, Block]:
        if not isinstance(start, Mapping):
            raise InputError(f"start is {start!r}; expected a mapping from names of blocks to values", field="start")
        blocks = dict(self._blocks)
        for name, values in start.items():
            block, given = self._block(name), np.atleast_1d(_floats(f"start of `{name}`", values))
            if given.shape != block.initial.shape:
                told = f"the start of `{name}` has shape {given.shape}; expected {block.initial.shape}"
                raise InputError(told, field=name)
            blocks[name] = replace(block, initial=given)
        return blocks

    def _relative(self, noise: Optional[str]) -> bool:
        if noise not in (None, "stated", "relative"):
            raise InputError(f"noise is `{noise}`; expected `stated` or `relative`", field="noise")
        if noise is not None:
            return noise == "relative"
        stated = {residual.name: residual.stated for residual in self._residuals.values()}
        if len(set(stated.values())) == 2:
            without = next(name for name, said in stated.items() if not said)
            told = f"`{without}` states no noise and others do: state std, or say noise=\"relative\" (std is 1 where it is not stated)"
            raise InputError(told, field=without)
        return not all(stated.values())

    def _check_jacobians(self, blocks: Mapping[str, Block]) -> None:
        values = list(blocks.values())
        for residual in self._residuals.values():
            residual.check_jacobian(
                np.concatenate([values[place].initial for place in residual.blocks]),
                [parameter for place in residual.blocks for parameter in values[place].parameters],
            )

    def _solution(self, blocks: Mapping[str, Block], found: _native.Estimated, solver: str) -> Solution:
        values, ends = np.array(found.values), np.cumsum([block.initial.size for block in blocks.values()])
        parts = dict(zip(blocks, np.split(values, ends[:-1])))
        judged = found.converged and bool(found.covariance)
        size = len(values)
        covariance = np.array(found.covariance).reshape(size, size) if judged else np.full((size, size), np.nan)
        undetermined = tuple(_combination(*one) for one in found.undetermined)
        owners = [(block, parameter) for block in blocks.values() for parameter in block.parameters]
        parameters = {}
        for place, (block, parameter) in enumerate(owners):
            known = found.determined[place] and found.converged
            own = judged and block.held is None
            parameters[parameter] = Parameter(
                name=parameter,
                unit=block.unit,
                value=float(values[place]) if known else None,
                std=float(np.sqrt(covariance[place, place])) if known and own else None,
                interval=found.intervals[place] if known and own else None,
                determined=known,
                held=block.held,
                why=None if known else _why(parameter, undetermined if found.converged else None),
            )
        free = [place for place, (block, name) in enumerate(owners) if block.held is None and parameters[name].determined]
        notes = [f"no standard deviations: {found.without_uncertainty}"] if found.without_uncertainty else []
        notes += [] if found.converged else [f"{solver} did not converge: `blocks` has where it ended"]
        local = {residual.name: np.concatenate([list(parts.values())[place] for place in residual.blocks]) for residual in self._residuals.values()}
        rows = np.cumsum([residual.rows for residual in self._residuals.values()])
        weights = np.split(np.array(found.weights), rows[:-1])
        complete = all(parameter.determined for parameter in parameters.values())
        return Solution(
            verdict=("determined" if complete else "partly-determined") if found.converged else "failed",
            termination=found.termination,
            parameters=parameters,
            blocks={name: float(part[0]) if blocks[name].components == [""] else part for name, part in parts.items()},
            names={name: block.parameters for name, block in blocks.items()},
            covariance=Covariance(tuple(owners[place][1] for place in free), covariance[np.ix_(free, free)]) if judged else None,
            undetermined=undetermined,
            weak=tuple(WeakCombination(_combination(*one), worse) for one, worse in found.weak),
            cost=found.cost,
            degrees_of_freedom=found.rows - found.rank,
            residuals={name: self._residuals[name].at(x) for name, x in local.items()},
            weights={one.name: part.reshape(one.shape) for one, part in zip(self._residuals.values(), weights)},
            active=dict(found.active),
            iterations=tuple(Iteration(*one) for one in found.iterations),
            singular_values=np.array(found.singular_values),
            notes=tuple(notes),
        )


def _combination(text: str, terms: list[tuple[str, str, float]]) -> Combination:
    return Combination(text, {name: coefficient for name, _unit, coefficient in terms})


def _why(parameter: str, undetermined: Optional[Sequence[Combination]]) -> str:
    if undetermined is None:
        return "the solver did not converge"
    own = [str(combination) for combination in undetermined if parameter in combination.terms]
    if own == [f"1.00 {parameter}"]:
        return "no residual depends on it"
    return f"the readings say nothing of {' and '.join(own) or 'it'}"


def _floats(what: str, given: Any) -> Floats:
    try:
        values = floats(f"the {what}", given, field=None)
    except InputError:
        raise InputError(f"the {what} is {given!r}; expected numbers") from None
    if not np.isfinite(values).all():
        raise InputError(f"the {what} is {given!r}; expected finite numbers")
    return values
