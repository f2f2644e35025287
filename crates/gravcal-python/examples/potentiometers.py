"""Potentiometers of Stanford and Scheinman arms, set to known angles in 1976 and 1977: the scale of each, with its uncertainty.

    counts = gain · set point + zero

The table is read where it lies, ``../shared/data/potentiometers`` beside the checkout or the folder in ``GRAVCAL_SHARED_DATA``.
"""

from __future__ import annotations

import csv
import os
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Optional

import numpy as np
from gravcal.estimation import Problem

BESIDE = Path(__file__).resolve().parents[4] / "shared/data"


def scale(points: Sequence[tuple[float, float]]) -> Optional[tuple[float, float]]:
    """Set point per count with its standard deviation, by the scatter about the line; nothing where no point is left to scatter."""
    set_points, counts = np.array(points).T
    problem = Problem()
    problem.add_block("gain", 1.0, linear=True)
    problem.add_block("zero", 0.0, linear=True)
    problem.add_residual(lambda gain, zero: gain * set_points + zero - counts, ["gain", "zero"])
    gain = problem.solve(solver="variable-projection")["gain"]
    if gain.value is None or gain.std is None:
        return None
    return 1.0 / gain.value, gain.std / gain.value**2


def joints(path: Path) -> dict[str, list[tuple[float, float]]]:
    """Set points and counts of each joint."""
    found = defaultdict(list)
    with path.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            name = f"{row['arm']}, joint {row['joint']}, {row['set_point_unit']}"
            found[name].append((float(row["set_point"]), float(row["adc_counts"])))
    return dict(found)


def main() -> dict[str, Optional[tuple[float, float]]]:
    path = Path(os.environ.get("GRAVCAL_SHARED_DATA", BESIDE)) / "potentiometers/pot_calibration.csv"
    if not path.exists():
        print(f"SKIPPED: there is no table of potentiometers at {path}")
        return {}
    scales = {name: scale(points) for name, points in joints(path).items()}
    for name, found in scales.items():
        told = "undetermined: too few set points" if found is None else f"{found[0]:.7f} ± {found[1]:.7f} per count"
        print(f"{name:<45} {told}")
    return scales


if __name__ == "__main__":
    main()
