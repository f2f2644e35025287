"""What is shown as a table: by `print`, and in notebooks."""

from __future__ import annotations

from html import escape
from typing import Protocol

__all__ = ["Tabled"]


class _HasTable(Protocol):
    @property
    def table(self) -> str: ...


class Tabled:
    """Shows its `table`."""

    def __str__(self: _HasTable) -> str:
        return self.table

    def _repr_html_(self: _HasTable) -> str:
        return f"<pre>{escape(self.table)}</pre>"
