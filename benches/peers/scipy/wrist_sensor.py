"""A force-torque sensor and an accelerometer in known orientations, by least squares of SciPy.

    python3 benches/peers/scipy/wrist_sensor.py ../shared/data/kuka_med14_wrist

`f = m g + b`, `n = c × g + b` of what the tool exerts on the sensor, and `a = -K M^T g + b` of the accelerometer, with g in the sensor's frame,
gravity's direction, gains K and the turn M beside the stated mounting open. Weights: each column by its own residuals. Shares no code with gravcal.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

GRAVITY = 9.82085  # m/s², as recorded beside the readings
MOUNTING = Rotation.from_euler("xyz", [-90, 90, 0], degrees=True).as_matrix()
NAMES = (
    "gravity.x gravity.y tool_mass tool_moment_x tool_moment_y tool_moment_z bias_fx bias_fy bias_fz bias_nx bias_ny bias_nz "
    "gain_x gain_y gain_z bias_x bias_y bias_z mounting_x mounting_y mounting_z"
).split()


def predicted(unknowns, base_from_body):
    x, y = unknowns[:2]
    gravity = base_from_body.transpose(0, 2, 1) @ np.array([x, y, -np.sqrt(GRAVITY**2 - x**2 - y**2)])
    force = unknowns[2] * gravity + unknowns[6:9]
    moment = np.cross(unknowns[3:6], gravity) + unknowns[9:12]
    turned = MOUNTING @ Rotation.from_rotvec(unknowns[18:21]).as_matrix()
    acceleration = -(gravity @ turned) * unknowns[12:15] + unknowns[15:18]
    return np.hstack([force, moment, acceleration])


def main(folder):
    table = np.genfromtxt(folder / "calibration_fts_accel.csv", delimiter=",", skip_header=1)
    readings, base_from_body = table[:, :9], table[:, 12:21].reshape(-1, 3, 3)
    unknowns, weights = np.zeros(21), np.ones(9)
    unknowns[2], unknowns[12:15] = 1.0, 0.1
    for _ in range(30):
        fit = least_squares(
            lambda unknowns: ((readings - predicted(unknowns, base_from_body)) * weights).ravel(),
            unknowns, xtol=1e-15, ftol=1e-15, gtol=1e-15,
        )
        unknowns = fit.x
        covariance = np.linalg.inv(fit.jac.T @ fit.jac)
        leverage = np.einsum("ij,jk,ik->i", fit.jac, covariance, fit.jac).reshape(-1, 9)
        residuals = fit.fun.reshape(-1, 9) / weights
        weights = 1.0 / np.sqrt((residuals**2).sum(axis=0) / (1.0 - leverage).sum(axis=0))
    for name, value, std in zip(NAMES, unknowns, np.sqrt(np.diag(covariance))):
        if name.startswith("mounting"):
            value, std, name = np.degrees(value), np.degrees(std), name + ", deg"
        print(f"{name:15} {value:12.6g} ± {std:.2g}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
