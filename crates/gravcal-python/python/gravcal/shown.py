"""A calibration to look at: in a browser, or in Rerun."""

from __future__ import annotations

import tempfile
import warnings
import webbrowser
from importlib import import_module
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .errors import GravcalError

__all__ = ["show_in_browser", "show_in_rerun"]


class _Residuals(Protocol):
    @property
    def channels(self) -> tuple[str, ...]: ...
    @property
    def units(self) -> tuple[str, ...]: ...
    @property
    def pose(self) -> NDArray[np.int64]: ...
    @property
    def channel(self) -> NDArray[np.int64]: ...
    @property
    def residual(self) -> NDArray[np.float64]: ...
    @property
    def before(self) -> NDArray[np.float64]: ...


def show_in_browser(page: str) -> Path:
    """The page stays in the folder for temporary files: a browser reads it when it likes. Where it is."""
    folder = Path(tempfile.mkdtemp(prefix="gravcal-"))
    path = folder / "report.html"
    path.write_text(page, encoding="utf-8")
    if not _opened(path.as_uri()):
        warnings.warn(f"there is no browser to show {path}; open it elsewhere, or save `page`", stacklevel=3)
    return path


def _opened(address: str) -> bool:
    try:
        return webbrowser.open(address)
    except webbrowser.Error:
        return False


def show_in_rerun(table: str, residuals: _Residuals) -> None:
    try:
        rerun = import_module("rerun")
    except ImportError:
        raise GravcalError("Rerun is not installed: pip install rerun-sdk") from None
    if rerun.get_global_data_recording() is None:
        rerun.init("gravcal", spawn=True)
    rerun.log("table", rerun.TextDocument(f"```\n{table}\n```", media_type="text/markdown"), static=True)
    for place, (name, unit) in enumerate(zip(residuals.channels, residuals.units)):
        own = residuals.channel == place
        for when, values in (("before", residuals.before), ("after", residuals.residual)):
            path = f"residuals/{name} [{unit}]/{when}"
            rerun.log(path, rerun.SeriesPoints(), static=True)
            poses = rerun.TimeColumn("pose", sequence=residuals.pose[own])
            rerun.send_columns(path, indexes=[poses], columns=rerun.Scalars.columns(scalars=values[own]))
