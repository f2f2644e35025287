"""A first calibration, from arrays.

Run it in the folder of a checkout: ``python crates/gravcal-python/examples/first_calibration.py``. The readings are those of a simulated
arm of seven joints; yours come from wherever your logger leaves them.
"""

from __future__ import annotations

import numpy as np
from gravcal import Robot, Session, read

FOLDER = "experiments/seven-joints-upright"
LOADS = ["weight-a", "weight-b"]

tables = [read(f"{FOLDER}/{name}.csv") for name in ["bare", *LOADS]]
cells = np.concatenate([table.cells for table in tables])
attached = [None] * len(tables[0]) + [name for name, table in zip(LOADS, tables[1:]) for _ in range(len(table))]

session = Session(
    Robot.from_toml("models/kuka-lbr-iiwa14/robot.toml"),
    position=cells[:, :7],
    torque=cells[:, 7:],
    position_unit="rad",
    torque_unit="N·m",
    torque_std=0.03,
    gravity={"magnitude_m_per_s2": 9.80665, "hemisphere": [0, 0, -1]},
    load=attached,
    loads=[{"name": name, "mass_kg": 5.0, "link": "link7"} for name in LOADS],
    load_distance=[{"between": LOADS, "distance_m": 0.14966629547095767}],
)
result = session.calibrate()
joint = result["joint"]

print(f"{joint.verdict}: {joint.termination}")
for name, parameter in joint.parameters.items():
    if parameter.value is not None and parameter.std is not None:
        print(f"{name:24} {parameter.value:10.5f} ± {parameter.std:.5f} {parameter.unit}")
    elif parameter.asked:
        print(f"{name:24} undetermined: {parameter.why}\n{'':25}cure: {parameter.cure}")
print(f"rms of residuals: {np.sqrt(np.mean(joint.residuals.residual**2)):.4f} N·m")
