"""What calling from Python costs: `Session.calibrate` from arrays beside what Rust does in the same call, and beside the program.

``python crates/gravcal-python/benches/overhead.py [POSES ...] [--runs N]`` in the root of a checkout. Both write how long their parts take into
`timing.json`; the session is the seven-joint experiment with as many poses. They run in turns, and the least of the runs counts: of the
ratio to Rust within one call, the median. What is not among the parts is the doubts, the record of the inputs, and `calibration.json`, which
the program writes, too, and in Python the results as values.
"""

from __future__ import annotations

import argparse
import json
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import gravcal
import numpy as np

ROOT = Path(__file__).resolve().parents[3]


def simulated(poses: int, folder: Path) -> Path:
    """A session with about so many poses."""
    source = ROOT / "experiments/seven-joints-upright"
    text = (source / "simulation.toml").read_text().replace("../../models", str(ROOT / "models"))
    text = re.sub(r"(?m)^random = \d+|^poses = \d+", lambda found: f"{found[0].split()[0]} = {poses // 3}", text)
    (folder / "simulation.toml").write_text(text)
    return Path(gravcal.simulate(folder / "simulation.toml", folder / "session"))


def of_arrays(path: Path) -> gravcal.Session:
    """The same session from arrays."""
    session = gravcal.Session.from_toml(path)
    return gravcal.Session(
        gravcal.Robot.from_toml(ROOT / "models/kuka-lbr-iiwa14/robot.toml"),
        position=np.array(session.position),
        torque=np.array(session.torque),
        position_unit="rad",
        torque_unit="N·m",
        torque_std=[0.05, 0.05, 0.04, 0.04, 0.03, 0.02, 0.02],
        gravity={"magnitude_m_per_s2": 9.80665, "hemisphere": [0, 0, -1]},
        load=session.loads,
        loads=[{"name": name, "mass_kg": 5.0, "link": "link7"} for name in ("weight-a", "weight-b")],
        load_distance=[{"between": ["weight-a", "weight-b"], "distance_m": 0.14966629547095767}],
    )


def parts(folder: Path) -> float:
    """Milliseconds that the estimators took."""
    times = json.loads((folder / "timing.json").read_text())
    return float(times["start_ms"] + times["solve_ms"] + times["judge_ms"])


def main() -> None:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("poses", nargs="*", type=int, default=[300, 2000, 20000])
    arguments.add_argument("--runs", type=int, default=5)
    asked = arguments.parse_args()
    program = ROOT / "target/release/gravcal"
    built = [str(program)] if program.exists() else [sys.executable, "-m", "gravcal"]
    print(f"program: {' '.join(built)}")
    print(f"{'poses':>6} {'program, ms':>12} {'Rust in Python, ms':>19} {'Python, ms':>11} {'to Rust':>8} {'to program':>11} {'session, ms':>12}")
    for poses in asked.poses:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            path = simulated(poses, folder)
            theirs, rust, ours, made = [], [], [], []
            for run in range(asked.runs):
                words = [*built, "calibrate", str(path), "--quiet", "--overwrite"]
                subprocess.run(words, check=False, stdout=subprocess.DEVNULL)
                theirs.append(parts(path.parent / "calibration"))
                begun = time.perf_counter()
                session = of_arrays(path)
                made.append(1e3 * (time.perf_counter() - begun))
                begun = time.perf_counter()
                result = session.calibrate()
                ours.append(1e3 * (time.perf_counter() - begun))
                result.save(folder / f"run{run}")
                rust.append(parts(folder / f"run{run}"))
            within = statistics.median(whole / part for whole, part in zip(ours, rust))
            told = f"{min(theirs):12.1f} {min(rust):19.1f} {min(ours):11.1f} {within:8.4f} {min(ours) / min(theirs):11.3f}"
            print(f"{len(session):6} {told} {min(made):12.1f}", flush=True)


if __name__ == "__main__":
    main()
