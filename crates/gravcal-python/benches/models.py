"""What a sensor model in Python costs: calibration with a ripple in joint 2, as a formula in Rust and as a function in Python.

``python crates/gravcal-python/benches/models.py [POSES ...]`` in the root of a checkout. A function of positions is called for all poses
at once, one that reads the torque pose by pose; the same ripple as a factor of the torque is the second pair. In turns; the least counts.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import gravcal
import numpy as np
from overhead import ROOT, simulated

RUNS = 3
NAMES = ["amplitude", "order", "phase"]


def models(scale: str) -> dict[str, Any]:
    """The ripple, with an amplitude of so much, by each way."""
    torque = scale == "torque"
    limits = [0.5, 0.1, 0.2]
    unknowns = {
        name: {"unit": unit, "nominal": start, "limit": limit}
        for name, unit, start, limit in zip(NAMES, ["N·m", "1/rad", "rad"], [0.02 if torque else 1.0, 6.0, 0.0], limits)
    }
    parameters = [gravcal.SensorParameter(name, str(one["unit"]), one["limit"], one["nominal"]) for name, one in unknowns.items()]

    def ripple(x: Any, poses: gravcal.Poses) -> Any:
        wave = x[0] * np.sin(x[1] * poses.position + x[2])
        return wave * poses.torque if torque else wave

    def slopes(x: Any, poses: gravcal.Poses) -> Any:
        angle, size = x[1] * poses.position + x[2], poses.torque if torque else np.ones(len(poses))
        return np.column_stack([size * np.sin(angle), size * x[0] * np.cos(angle) * poses.position, size * x[0] * np.cos(angle)])

    how: dict[str, Any] = {"parameters": parameters, "reads": ["torque"] if torque else [], "affine_in_torque": torque}
    wave = "amplitude * sin(order * position + phase)"
    return {
        "formula, in Rust": ({"kind": "formula", "adds": f"{wave} * torque" if torque else wave, "unknowns": unknowns}, []),
        "Python, with jacobian": ({"kind": "ripple"}, [gravcal.SensorModel("ripple", ripple, jacobian=slopes, **how)]),
        "Python, differences": ({"kind": "ripple"}, [gravcal.SensorModel("ripple", ripple, **how)]),
    }


def arguments(path: Path, scale: str) -> dict[str, Any]:
    """The session with the ripple in its readings."""
    session = gravcal.Session.from_toml(path)
    wave = np.sin(6.1 * session.position[:, 1] + 0.4)
    torque = session.torque.copy()
    torque[:, 1] += 0.03 * torque[:, 1] * wave if scale == "torque" else 2.0 * wave
    return {
        "robot": gravcal.Robot.from_toml(ROOT / "models/kuka-lbr-iiwa14/robot.toml"),
        "position": session.position, "torque": torque, "position_unit": "rad", "torque_unit": "N·m", "torque_std": 0.04,
        "gravity": {"magnitude_m_per_s2": 9.80665, "hemisphere": [0, 0, -1]},
        "load": session.loads,
        "loads": [{"name": name, "mass_kg": 5.0, "link": "link7"} for name in ("weight-a", "weight-b")],
        "load_distance": [{"between": ["weight-a", "weight-b"], "distance_m": 0.14966629547095767}],
    }


def main() -> None:
    print(f"{'poses':>6}  {'adds to the reading':20} {'by':22} {'ms':>9} {'to Rust':>8} {'amplitude':>10}")
    for poses in [int(word) for word in sys.argv[1:]] or [300, 2000]:
        with tempfile.TemporaryDirectory() as folder:
            path = simulated(poses, Path(folder))
            for scale in ("a wave", "torque"):
                given, times, found = arguments(path, scale), dict[str, list[float]](), {}
                for _ in range(RUNS):
                    for name, (kind, own) in models(scale).items():
                        session = gravcal.Session(**given, models=own, joint=[{"name": "joint2", "sensor_models": [kind]}])
                        begun = time.perf_counter()
                        found[name] = session.calibrate("joint")["joint"]["joint2.amplitude"].value
                        times.setdefault(name, []).append(1e3 * (time.perf_counter() - begun))
                for name, own_times in times.items():
                    ratio = min(own_times) / min(times["formula, in Rust"])
                    told = "wave * torque" if scale == "torque" else scale
                    print(f"{len(given['torque']):6}  {told:20} {name:22} {min(own_times):9.1f} {ratio:8.2f} {found[name]:10.6f}", flush=True)


if __name__ == "__main__":
    main()
