"""The threads of a calibration, which a process that is forked after it has lost: it would wait for them for ever."""

from __future__ import annotations

import os

from .errors import GravcalError

__all__ = ["use_threads"]

_started = False
_lost = False


def use_threads() -> None:
    """To be called before work that uses them. Raises `GravcalError` where they are lost."""
    global _started
    if _lost:
        raise GravcalError(
            "this process was forked after gravcal had worked in its parent, and lost gravcal's threads: start processes by "
            'multiprocessing.get_context("spawn") or ("forkserver"), or fork before the first check, calibration or solve'
        )
    _started = True


def _in_child() -> None:
    global _lost
    _lost = _started


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_in_child)
