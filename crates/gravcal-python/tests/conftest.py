"""What the tests share: the checkout, the program, and sessions from arrays."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import gravcal
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
SEVEN = ROOT / "experiments/seven-joints-upright"
"""300 poses of seven joints, with two loads."""


def program(*words: Any) -> "subprocess.CompletedProcess[str]":
    """Runs the program that cargo built, where it did, else the one of the package."""
    built = ROOT / "target/release/gravcal"
    command = [str(built)] if built.exists() else [sys.executable, "-m", "gravcal"]
    return subprocess.run([*command, *map(str, words)], capture_output=True, text=True, check=False)


def sessions() -> list[Path]:
    """Those of the experiments whose recordings are here."""
    found = sorted(ROOT.glob("experiments/*/session.toml"))
    assert found, "there is no experiment"
    return found


def arrays_of_seven() -> dict[str, Any]:
    """The experiment, as arguments of a session."""
    names = ["bare", "weight-a", "weight-b"]
    tables = [gravcal.read(SEVEN / f"{name}.csv") for name in names]
    cells = np.concatenate([table.cells for table in tables])
    load = [None if name == "bare" else name for name, table in zip(names, tables) for _ in range(len(table))]
    return {
        "robot": gravcal.Robot.from_toml(ROOT / "models/kuka-lbr-iiwa14/robot.toml"),
        "position": cells[:, :7],
        "torque": cells[:, 7:],
        "position_unit": "rad",
        "torque_unit": "N·m",
        "torque_std": [0.05, 0.05, 0.04, 0.04, 0.03, 0.02, 0.02],
        "gravity": {"magnitude_m_per_s2": 9.80665, "hemisphere": [0, 0, -1]},
        "load": load,
        "loads": [{"name": name, "mass_kg": 5.0, "link": "link7"} for name in names[1:]],
        "load_distance": [{"between": names[1:], "distance_m": 0.14966629547095767}],
    }


@pytest.fixture(autouse=True)
def interrupts() -> None:
    """Heeded, as Python does unless it is started in the background of a script."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture()
def seven() -> dict[str, Any]:
    return arrays_of_seven()


@pytest.fixture(scope="session")
def calibrated() -> gravcal.Calibration:
    return gravcal.Session(**arrays_of_seven()).calibrate()


def pytest_report_header() -> str:
    return f"gravcal from {os.path.dirname(gravcal.__file__)}"
