"""Residual functions of users, called and checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any, Callable, Optional, Protocol

import numpy as np

from ..arrays import floats, read_only, returned
from ..errors import InputError
from ..recording import Floats
from .differences import by_differences, mismatch

__all__ = ["BlockLayout", "Residual"]


class _Block(Protocol):
    @property
    def name(self) -> str: ...
    @property
    def components(self) -> list[str]: ...
    @property
    def scale(self) -> Floats: ...


@dataclass(frozen=True)
class BlockLayout:
    """How the numbers of some blocks, one after the other, become arguments of a function."""

    names: tuple[str, ...]
    ends: tuple[int, ...]
    numbers: tuple[bool, ...]
    """Whether each block is a number, no array."""
    scale: Floats

    @classmethod
    def of(cls, blocks: Sequence[_Block]) -> BlockLayout:
        ends = np.cumsum([len(block.components) for block in blocks])
        return cls(
            tuple(block.name for block in blocks),
            tuple(int(end) for end in ends),
            tuple(block.components == [""] for block in blocks),
            np.concatenate([block.scale for block in blocks]) if blocks else np.zeros(0),
        )

    def arguments(self, x: Floats) -> list[Any]:
        """Arrays among them cannot be written into."""
        parts = np.split(read_only(x.view()), self.ends[:-1])
        return [float(part[0]) if number else part for part, number in zip(parts, self.numbers)]


@dataclass(frozen=True)
class Residual:
    """A residual, as the solver takes it."""

    name: str
    function: Callable[..., Any]
    jacobian: Optional[Callable[..., Any]]
    layout: BlockLayout
    blocks: list[int]
    loss: str
    width: Optional[float]
    shape: tuple[int, ...]
    std: Floats
    covariance: Optional[list[float]]
    stated: bool

    @classmethod
    def of(
        cls,
        name: str,
        function: Callable[..., Any],
        jacobian: Optional[Callable[..., Any]],
        layout: BlockLayout,
        blocks: list[int],
        *,
        loss: str,
        width: Optional[float],
    ) -> Residual:
        if not blocks:
            raise InputError(f"residual `{name}` reads no block", field=name)
        if len(set(blocks)) != len(blocks):
            raise InputError(f"residual `{name}` reads a block twice", field=name)
        _refuse_loss(name, loss, width)
        return cls(name, function, jacobian, layout, blocks, loss, width, (), np.ones(0), None, False)

    @property
    def rows(self) -> int:
        return int(np.prod(self.shape))

    def tried(self, x: Floats) -> Residual:
        """The same with the shape that it has here."""
        values = self._called(x, for_differences=self.jacobian is None)
        if values.size == 0:
            raise InputError(f"residual `{self.name}` is empty: leave it away", field=self.name)
        if not np.isfinite(values).all():
            place = tuple(int(index) for index in np.argwhere(~np.isfinite(values))[0])
            told = f"residual `{self.name}` is {values[place]} at {list(place)} where the search starts; start elsewhere, or leave that reading away"
            raise InputError(told, field=self.name)
        return replace(self, shape=values.shape)

    def with_noise(self, std: Any, covariance: Any) -> Residual:
        """The same with what is said of its noise."""
        if std is not None and covariance is not None:
            raise InputError(f"residual `{self.name}` has std and covariance: say one of them", field=self.name)
        if covariance is not None:
            matrix = floats(f"the covariance of `{self.name}`", covariance, field=self.name)
            if matrix.shape != (self.rows, self.rows):
                told = f"the covariance of `{self.name}` is {matrix.shape}; expected {(self.rows, self.rows)}"
                raise InputError(told, field=self.name)
            return replace(self, covariance=matrix.ravel().tolist(), stated=True)
        given = floats(f"the std of `{self.name}`", 1.0 if std is None else std, field=self.name)
        wrong = given[~(np.isfinite(given) & (given > 0.0))]
        if wrong.size:
            raise InputError(f"the std of `{self.name}` is {wrong[0]}; it must be positive and finite", field=self.name)
        try:
            spread = np.broadcast_to(given, self.shape)
        except ValueError:
            told = f"the std of `{self.name}` has shape {np.shape(std)}; expected one for all, or the shape {self.shape} of the residual"
            raise InputError(told, field=self.name) from None
        return replace(self, std=spread.flatten(), stated=std is not None)

    def evaluate(self, x: Floats, with_jacobian: bool) -> tuple[Floats, Optional[Floats]]:
        """What the solver asks for: rows, and their derivatives."""
        return self.at(x).ravel(), self._slopes(x) if with_jacobian else None

    def at(self, x: Floats, *, for_differences: bool = False) -> Floats:
        """The residual in its shape."""
        values = self._called(x, for_differences)
        if values.shape != self.shape:
            told = f"residual `{self.name}` has shape {values.shape}, and had {self.shape} where the search starts"
            raise InputError(told, field=self.name)
        return values

    def check_jacobian(self, x: Floats, parameters: Sequence[str]) -> None:
        """Compares its derivatives with differences, where they are given."""
        if self.jacobian is None:
            return
        given, found = self._slopes(x), self._differences(x)
        wrong = mismatch(given, found, self.layout.scale)
        if wrong is not None:
            row, column = wrong
            place = [int(index) for index in np.unravel_index(row, self.shape)]
            told = (
                f"the derivative of residual `{self.name}` at {place} by `{parameters[column]}` is {given[row, column]:g}; "
                f"differences give {found[row, column]:g}. Mend `jacobian`, or leave it away"
            )
            raise InputError(told, field=self.name)

    def _slopes(self, x: Floats) -> Floats:
        if self.jacobian is None:
            return self._differences(x)
        answer = self.jacobian(*self.layout.arguments(x))
        if answer is None:
            raise InputError(f"the jacobian of `{self.name}` returned None: is there no `return` in it?", field=self.name)
        parts = list(answer) if isinstance(answer, (tuple, list)) else [answer]
        if len(parts) != len(self.layout.names):
            told = f"the jacobian of `{self.name}` gives {len(parts)} arrays; expected one for each of {', '.join(self.layout.names)}"
            raise InputError(told, field=self.name)
        columns = []
        for part, block, number, width in zip(parts, self.layout.names, self.layout.numbers, self._widths()):
            slopes = returned(f"the jacobian of `{self.name}` by `{block}`", part, field=self.name)
            expected = self.shape if number else (*self.shape, width)
            if slopes.shape != expected:
                told = f"the jacobian of `{self.name}` by `{block}` has shape {slopes.shape}; expected {expected}"
                raise InputError(told, field=self.name)
            columns.append(slopes.reshape(self.rows, width))
        return np.hstack(columns)

    def _widths(self) -> list[int]:
        return [end - begin for begin, end in zip((0, *self.layout.ends), self.layout.ends)]

    def _differences(self, x: Floats) -> Floats:
        return by_differences(lambda x: self.at(x, for_differences=True).ravel(), x, self.layout.scale)

    def _called(self, x: Floats, for_differences: bool) -> Floats:
        values = self.function(*self.layout.arguments(x))
        return returned(f"the function of `{self.name}`", values, field=self.name, for_differences=for_differences)


_LOSSES = ("none", "huber", "cauchy", "tukey", "geman-mcclure")


def _refuse_loss(name: str, loss: str, width: Any) -> None:
    if loss not in _LOSSES:
        raise InputError(f"residual `{name}` has the unknown loss `{loss}`; there is {', '.join(_LOSSES)}", field=name)
    if width is None:
        return
    if loss == "none":
        raise InputError(f"residual `{name}` has a width and no loss: say which, such as loss=\"huber\"", field=name)
    if not isinstance(width, Real) or not 0.0 < float(width) < np.inf:
        raise InputError(f"the width of the loss of `{name}` is {width!r}; expected a positive number of standard deviations", field=name)
