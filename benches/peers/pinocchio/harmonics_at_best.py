"""How often the best of all tests could see uneven position sensors behind friction at rest, in recordings that `real_arms` kept.

    cargo run --release -p gravcal-benches --bin real_arms -- --line harmonics --friction-nm 0.1 --sessions 24 --seed 31 --keep kept
    python3 benches/peers/pinocchio/harmonics_at_best.py kept/harmonics-0.1-*        (`pip install pin numpy scipy`)

By the true arm: the effect of the harmonics on torques, less what gains, biases, offsets, gravity, masses and the load's place take of it, over the
scatter of friction at rest (0.49 of Coulomb friction) and noise, is a vector; its length is what a test sees that knows its direction beforehand (Neyman and
Pearson). None names more of them at the same share of false alarms, 1 %. Arms without a URDF are left out.
"""

import sys
import tomllib
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.stats import norm

AT_REST = 0.49  # rms of friction at rest, as a share of Coulomb friction
NOISE, SAMPLES = 0.03, 300  # N·m a sample, samples of a dwell
FALSE_ALARMS = 0.01
AMPLITUDE, ORDER = 7e-4, 2  # rad, of sine and of cosine, of each joint


class Arm:
    """A URDF with gravity and load of a simulation; torques of its read joints and their derivatives."""

    def __init__(self, folder):
        session = tomllib.loads((folder / "session.toml").read_text())
        simulation = tomllib.loads((folder / "simulation.toml").read_text())
        self.model = pin.buildModelFromUrdf(str(folder / session["robot"]["urdf"]))
        joints = [column.split(".")[0] for column in session["readings"]["position"]["columns"]]
        self.ids = [self.model.getJointId(joint) for joint in joints]
        self.velocities = [self.model.joints[i].idx_v for i in self.ids]
        direction = np.array(simulation["gravity"]["direction"], dtype=float)
        self.gravity = direction / np.linalg.norm(direction) * simulation["gravity"]["magnitude_m_per_s2"]
        load = simulation["load"][0]
        frame = self.model.frames[self.model.getFrameId(load["link"])]
        self.carrier = frame.parentJoint
        self.loaded = self.model.copy()
        at = frame.placement.act(np.array(load["position_m"]))
        self.loaded.inertias[self.carrier] += pin.Inertia(load["mass_kg"], at, np.zeros((3, 3)))

    def configuration(self, angles):
        q = pin.neutral(self.model)
        for angle, i in zip(angles, self.ids):
            joint = self.model.joints[i]
            q[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(angle), np.sin(angle)] if joint.nq == 2 else [angle]
        return q

    def columns(self, angles, is_loaded):
        """Derivatives of the torques by what is estimated, and by the harmonics of each joint."""
        model = self.loaded if is_loaded else self.model
        data, q, rows = model.createData(), self.configuration(angles), self.velocities
        by_axis = []
        for axis in np.eye(3):
            model.gravity.linear = axis
            by_axis.append(pin.computeGeneralizedGravity(model, data, q)[rows])
        model.gravity.linear = self.gravity
        torque = pin.computeGeneralizedGravity(model, data, q)[rows]
        stiffness = pin.computeGeneralizedGravityDerivatives(model, data, q)[np.ix_(rows, rows)]
        still = np.zeros(model.nv)
        regressor = pin.computeJointTorqueRegressor(self.model, self.model.createData(), q, still, still)[rows]
        masses = regressor.reshape(len(rows), -1, 10)[:, :, :4]
        place = masses[:, self.carrier - 1, 1:] * is_loaded
        turned = np.array(by_axis).T @ np.linalg.svd(self.gravity[None])[2][1:].T
        estimated = [np.diag(torque), np.eye(len(rows)), stiffness * angles, stiffness, turned]
        estimated += [masses.reshape(len(rows), -1), place]
        harmonics = stiffness @ (AMPLITUDE * (np.sin(ORDER * angles) + np.cos(ORDER * angles)))
        return np.hstack(estimated), harmonics


def standstills(path):
    """Mean angles of the stretches in which nothing moves."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    columns = [place for place, name in enumerate(lines[0].split(",")) if name.endswith(".position")]
    angles = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])[:, columns]
    still = np.abs(angles[10:] - angles[:-10]).max(axis=1) < 1e-4
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    return [angles[a + 60 : b].mean(axis=0) for a, b in zip(edges[::2], edges[1::2]) if b - a > 150]


def power(folder, friction):
    arm = Arm(folder)
    poses = [(q, 0) for q in standstills(folder / "bare.csv")] + [(q, 1) for q in standstills(folder / "loaded.csv")]
    estimated, effect = zip(*(arm.columns(*pose) for pose in poses))
    estimated, effect = np.vstack(estimated), np.concatenate(effect)
    basis, sizes, _ = np.linalg.svd(estimated, full_matrices=False)
    basis = basis[:, sizes > 1e-10 * sizes[0]]
    left = effect - basis @ (basis.T @ effect)
    seen = np.linalg.norm(left) / np.hypot(AT_REST * friction, NOISE / np.sqrt(SAMPLES))
    return seen, norm.sf(norm.isf(FALSE_ALARMS) - seen)


def main(folders):
    arms = {}
    for folder in map(Path, folders):
        urdf = tomllib.loads((folder / "session.toml").read_text())["robot"]
        if isinstance(urdf, dict) and "urdf" in urdf:
            friction = float(folder.name.split("-")[1])
            arms.setdefault((Path(urdf["urdf"]).name, friction), []).append(power(folder, friction))
    for (arm, friction), found in arms.items():
        seen, named = np.mean(found, axis=0)
        print(f"{arm}, {friction} N·m, {len(found)} recordings: {seen:.1f} standard deviations, named at best in {100 * named:.0f} %")


if __name__ == "__main__":
    main(sys.argv[1:])
