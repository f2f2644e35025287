"""What calling from Python costs: `Session.calibrate` from arrays beside the program's own times.

``python crates/gravcal-python/benches/overhead.py [POSES ...]`` in the root of a checkout. The program tells how long its parts take in
`timing.json`; the session is the seven-joint experiment with as many poses. The least of the runs counts, in turns.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import gravcal
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
RUNS = 5


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


def main() -> None:
    program = ROOT / "target/release/gravcal"
    print(f"{'poses':>6} {'program, ms':>12} {'Python, ms':>12} {'ratio':>6} {'session from arrays, ms':>24}")
    for poses in [int(word) for word in sys.argv[1:]] or [300, 2000, 20000]:
        with tempfile.TemporaryDirectory() as folder:
            path = simulated(poses, Path(folder))
            theirs, ours, built = [], [], []
            for _ in range(RUNS):
                words = [program, "calibrate", path, "--quiet", "--overwrite"]
                subprocess.run(words, check=False, stdout=subprocess.DEVNULL)
                times = json.loads((path.parent / "calibration/timing.json").read_text())
                theirs.append(sum(times[part] for part in ("start_ms", "solve_ms", "judge_ms")))
                begun = time.perf_counter()
                session = of_arrays(path)
                built.append(1e3 * (time.perf_counter() - begun))
                begun = time.perf_counter()
                session.calibrate()
                ours.append(1e3 * (time.perf_counter() - begun))
            told = f"{min(ours) / min(theirs):6.3f} {min(built):24.1f}"
            print(f"{len(session):6} {min(theirs):12.1f} {min(ours):12.1f} {told}")


if __name__ == "__main__":
    main()
