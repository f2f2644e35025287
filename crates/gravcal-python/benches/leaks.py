"""Whether anything is leaked: each call of the package so many times, and how much more memory the process holds afterwards.

``python crates/gravcal-python/benches/leaks.py [--calls N] [NAME ...]`` in the root of a checkout, on Linux. Memory is what the process holds
(`/proc/self/statm`) after a collection, before and after the calls; a tenth as many go before, which fill what is kept once. It ends with
exit code 1 where 100 bytes or more remain of each call, and a megabyte in all.
"""

from __future__ import annotations

import argparse
import copy
import gc
import os
import pickle
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

import gravcal
import numpy as np
from gravcal.estimation import Problem

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from conftest import SEVEN, arrays_of_seven

MOST = 100.0
"""Bytes a call; an array of the poses is more."""
RESERVE = 1 << 20
"""Bytes that an allocator may keep in reserve."""
ROUNDS = 3
"""An allocator takes memory in steps, of four megabytes and more, and keeps it; what is leaked grows in every round."""


def resident() -> int:
    """Bytes that the process holds."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def few() -> dict[str, Any]:
    """Every tenth pose, which are read and solved fast."""
    seven = arrays_of_seven()
    return {**seven, **{name: seven[name][::10] for name in ("position", "torque", "load")}}


def refused(call: Callable[[], Any], kind: type[Exception]) -> None:
    """What must raise, and does."""
    try:
        call()
    except kind:
        return
    raise SystemExit(f"{call} raised no {kind.__name__}")


def calls(folder: Path) -> dict[str, Callable[[], Any]]:
    """Everything that is called, by name."""
    arrays = few()
    arrays["torque_std"] = np.full(arrays["torque"].shape, 0.05)
    session = gravcal.Session(**arrays)
    calibration = session.calibrate("joint")
    converted = {**arrays, **{name: np.asfortranarray(arrays[name], dtype=np.float32) for name in ("position", "torque")}}
    wrong = {**arrays, "torque": arrays["torque"] * np.nan}
    wave = gravcal.SensorModel("wave", lambda x, poses: x[0] * np.sin(poses.position), parameters=[gravcal.SensorParameter("height", "N·m", 0.1)])
    waved = gravcal.Session(**arrays, models=[wave], joint=[{"name": "joint2", "sensor_models": [{"kind": "wave"}]}])
    table = folder / "few.csv"
    table.write_text("".join((SEVEN / "bare.csv").read_text().splitlines(keepends=True)[:5]))
    x = np.linspace(0.0, 1.0, 200)

    def enough(stage: str) -> None:
        raise RuntimeError(stage)

    def solve(residual: Callable[[Any], Any]) -> Any:
        problem = Problem()
        problem.add_block("a", 1.0)
        problem.add_residual(residual, "a", std=0.1)
        return problem.solve()

    return {
        "session": lambda: gravcal.Session(**arrays),
        "session, float32, Fortran order": lambda: gravcal.Session(**converted),
        "session, refused": lambda: refused(lambda: gravcal.Session(**wrong), gravcal.InputError),
        "arrays of a session": lambda: (session.position, session.torque, session.loads, repr(session)),
        "check": session.check,
        "calibrate": lambda: session.calibrate("joint", progress=len),
        "calibrate, refused": lambda: refused(lambda: session.calibrate("kalman"), gravcal.InputError),
        "calibrate, ended by progress": lambda: refused(lambda: session.calibrate("joint", progress=enough), RuntimeError),
        "calibrate, own sensor model": lambda: waved.calibrate("joint"),
        "table and page": lambda: (calibration.table, calibration.page, calibration._repr_html_()),
        "pickle and copy": lambda: (pickle.loads(pickle.dumps(calibration)), copy.copy(session)),
        "apply": lambda: session.apply(calibration, position=arrays["position"], torque=arrays["torque"], nominal=True),
        "read": lambda: gravcal.read(table),
        "estimation": lambda: solve(lambda a: np.exp(a * x) - 2.0),
        "estimation, residual that raises": lambda: refused(lambda: solve(lambda a: int("moved")), ValueError),
    }


def main() -> None:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("names", nargs="*")
    arguments.add_argument("--calls", type=int, default=10000)
    asked = arguments.parse_args()
    leaked = []
    print(f"{'call':34} {'calls':>6} {'s':>7} {'grown, KiB':>11} {'bytes a call':>13}")
    with tempfile.TemporaryDirectory() as folder:
        there = calls(Path(folder))
        unknown = set(asked.names) - set(there)
        if unknown:
            raise SystemExit(f"there is no {', '.join(sorted(unknown))}; there is: {'; '.join(there)}")
        for name in asked.names or there:
            for _ in range(max(1, asked.calls // 10)):
                there[name]()
            for _ in range(ROUNDS):
                before, begun = resident(), time.perf_counter()
                for _ in range(asked.calls):
                    there[name]()
                took, grown = time.perf_counter() - begun, resident() - before
                print(f"{name:34} {asked.calls:6} {took:7.1f} {grown / 1024:11.1f} {grown / asked.calls:13.1f}", flush=True)
                if grown < max(MOST * asked.calls, RESERVE):
                    break
            else:
                leaked.append(name)
    if leaked:
        raise SystemExit(f"leaked: {', '.join(leaked)}")


if __name__ == "__main__":
    main()
