"""What is shown by `print`, and in notebooks: a table, or one screen of it."""

from __future__ import annotations

from html import escape
from typing import Protocol

__all__ = ["Summarised", "Tabled", "for_python"]


class _HasTable(Protocol):
    @property
    def table(self) -> str: ...


class Tabled:
    """Shows its `table`."""

    def __str__(self: _HasTable) -> str:
        return self.table

    def _repr_html_(self: _HasTable) -> str:
        return f"<pre>{escape(self.table)}</pre>"


class _HasSummary(Protocol):
    @property
    def summary(self) -> str: ...


class Summarised:
    """Shows its `summary`."""

    def __str__(self: _HasSummary) -> str:
        return self.summary

    def _repr_html_(self: _HasSummary) -> str:
        return f"<pre>{escape(self.summary)}</pre>"


def for_python(told: str) -> str:
    """A screen of the program, which names its option for all tables."""
    return told.replace("--full", ".table")
