"""What unknowns must obey: as the solver takes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["Affine"]


@dataclass(frozen=True)
class Affine:
    """`constant + Σ coefficient · component`; components by name: a block's of one number (`gain`), else `bias.x`."""

    terms: Mapping[str, float] = field(default_factory=dict)
    constant: float = 0.0


@dataclass(frozen=True)
class PlacedAffine:
    """The same with blocks and components by their places."""

    terms: list[tuple[int, int, float]]
    constant: float


@dataclass(frozen=True)
class Range:
    """`lower <= function <= upper`."""

    name: str
    function: PlacedAffine
    lower: float
    upper: float


@dataclass(frozen=True)
class Cone:
    """The length of `norm_of` is at most `at_most`."""

    name: str
    norm_of: list[PlacedAffine]
    at_most: PlacedAffine


@dataclass(frozen=True)
class Length:
    """A block has this length."""

    name: str
    block: int
    length: float
