"""One joint problem with arrays in, by gravcal and by three peers: recordings of a KUKA LWR4+ (`../shared/data/kuka_lwr4`, beside the checkout).

    tau = gravity torque of 7 links (masses and first moments unknown, direction of gravity unknown) + bias + Fc sign(qd) + Fv qd

of rows in which the arm hardly accelerates; 1 N·m noise for every reading, so that all minimise the same sum of squares. SciPy gets the
regressor by Pinocchio and its exact Jacobian; MuJoCo's sysid its own inverse dynamics as the residual, and differences; FIGAROH its own
regressor and base parameters, with gravity held upright, as its problem is linear. Each is timed from arrays to answer; the ratios are those
of one run, and predicted torques are compared with gravcal's.

``pip install scipy pin figaroh "mujoco[sysid]"``, then ``python crates/gravcal-python/benches/peers.py [ROWS]`` in the root of a checkout. A
peer that is not installed is left out, and said so.
"""

from __future__ import annotations

import contextlib
import io
import logging
import os
import sys
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable

import gravcal
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
DATA = Path(os.environ.get("GRAVCAL_SHARED_DATA", ROOT.parent / "shared/data")) / "kuka_lwr4"
GRAVITY = 9.81
JOINTS = [f"lwr_{joint}_joint" for joint in range(7)]
RUNS = 3


@dataclass(frozen=True)
class Rows:
    """Arrays, a row each sample and a column each joint; positions, velocities, torques."""

    q: Any
    qd: Any
    tau: Any


def recorded(most: int) -> Rows:
    """Rows of the first recording without much acceleration, evenly thinned."""
    table = gravcal.read(DATA / "recording_1.csv")
    q, qd, tau = (np.column_stack([table[f"{name}{joint}_{unit}"] for joint in range(1, 8)]) for name, unit in (("q", "rad"), ("qd", "rad_per_s"), ("tau", "Nm")))
    acceleration = np.gradient(qd, table["time_s"], axis=0)
    calm = np.flatnonzero(np.abs(acceleration).max(axis=1) < 0.5)
    chosen = calm[np.unique(np.linspace(0, len(calm) - 1, most).astype(int))]
    return Rows(q[chosen], qd[chosen], tau[chosen])


def by_gravcal(rows: Rows) -> Callable[[], Any]:
    said = {
        "robot": {"urdf": str(DATA / "kuka_lwr4.urdf"), "base": "lwr_base_link", "tip": "lwr_7_link"},
        "gravity": {"magnitude_m_per_s2": GRAVITY, "hemisphere": [0, 0, -1]},
        "readings": {
            name: {"columns": [f"{name}[{joint}]" for joint in JOINTS], "unit": unit, **more}
            for name, unit, more in [("position", "rad", {}), ("velocity", "rad/s", {}), ("torque", "N·m", {"std": 1.0})]
        },
        "joints": {
            "torque_sign": "normal",
            "torque_gain": {"fixed": 1.0, "unit": "N·m/(N·m)"},
            "position_gain": {"fixed": 1.0, "unit": "rad/rad"},
            "position_offset": {"fixed": 0.0, "unit": "rad"},
            "sensor_models": [{"kind": "coulomb-friction"}, {"kind": "viscous-friction"}],
        },
        "poses": [{"file": "rows"}],
    }
    arrays = {"position": rows.q, "velocity": rows.qd, "torque": rows.tau}
    table = {f"{name}[{joint}]": array[:, place] for name, array in arrays.items() for place, joint in enumerate(JOINTS)}

    def solve() -> Any:
        joint = gravcal.Session.from_dict(said, {"rows": table}).calibrate("joint")["joint"]
        assert joint.verdict != "failed", joint.termination
        # Prediction less reading, pose after pose.
        residual = np.full(rows.tau.shape, np.nan)
        residual[joint.residuals.pose, joint.residuals.channel] = joint.residuals.residual
        return rows.tau + residual

    return solve


def friction(rows: Rows) -> Any:
    """Columns of bias, Coulomb and viscous friction, joint by joint: samples × joints × 21."""
    columns = np.zeros((*rows.q.shape, 21))
    for joint in range(7):
        columns[:, joint, joint] = 1.0
        columns[:, joint, 7 + joint] = np.sign(rows.qd[:, joint])
        columns[:, joint, 14 + joint] = rows.qd[:, joint]
    return columns


def direction(tilt: Any) -> tuple[Any, Any]:
    """Gravity, tilted from upright by two angles, and its derivatives."""
    (a, b), (sin_a, cos_a), (sin_b, cos_b) = tilt, (np.sin(tilt[0]), np.cos(tilt[0])), (np.sin(tilt[1]), np.cos(tilt[1]))
    vector = GRAVITY * np.array([sin_a * cos_b, sin_b, -cos_a * cos_b])
    by_tilt = GRAVITY * np.array([[cos_a * cos_b, -sin_a * sin_b], [0.0, cos_b], [sin_a * cos_b, cos_a * sin_b]])
    return vector, by_tilt


def by_scipy(rows: Rows) -> Callable[[], Any]:
    import pinocchio
    from scipy.optimize import least_squares

    model = pinocchio.buildModelFromUrdf(str(DATA / "kuka_lwr4.urdf"))
    data, still = model.createData(), np.zeros(model.nv)
    static = [10 * link + place for link in range(7) for place in range(4)]

    def solve() -> Any:
        by_axis = []
        for axis in np.eye(3):
            model.gravity.linear = axis
            by_axis.append([pinocchio.computeJointTorqueRegressor(model, data, q, still, still)[:, static] for q in rows.q])
        regressors, own = np.array(by_axis), friction(rows)

        def residual(x: Any) -> Any:
            gravity, _ = direction(x[:2])
            return (np.tensordot(gravity, regressors @ x[2:30], 1) + own @ x[30:] - rows.tau).ravel()

        def jacobian(x: Any) -> Any:
            gravity, by_tilt = direction(x[:2])
            tilted = np.tensordot(by_tilt.T, regressors @ x[2:30], 1)
            parts = [np.moveaxis(tilted, 0, -1), np.tensordot(gravity, regressors, 1), own]
            return np.concatenate(parts, axis=-1).reshape(-1, 51)

        inertias = np.concatenate([model.inertias[link].toDynamicParameters()[:4] for link in range(1, 8)])
        found = least_squares(residual, np.concatenate([np.zeros(2), inertias, np.zeros(21)]), jacobian, x_scale="jac")
        assert found.success, found.message
        return rows.tau + found.fun.reshape(rows.tau.shape)

    return solve


def for_mujoco(path: Path) -> str:
    """The URDF without what only shows, as its meshes are not there, and without what is said twice: the first counts."""
    robot = ElementTree.parse(path).getroot()
    for element in list(robot.iter()):
        seen: set[str] = set()
        for child in list(element):
            if child.tag in ("visual", "collision", "gazebo", "transmission") or (child.tag == "origin" and "origin" in seen):
                element.remove(child)
            seen.add(child.tag)
    settings = {"fusestatic": "false", "discardvisual": "true", "balanceinertia": "true"}
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", settings)
    return ElementTree.tostring(robot, encoding="unicode")


def by_mujoco(rows: Rows) -> Callable[[], Any]:
    import mujoco
    from mujoco import sysid

    # Of masses below zero, on the way; else they go to a file.
    mujoco.set_mju_user_warning(lambda message: None)
    text = for_mujoco(DATA / "kuka_lwr4.urdf")

    def solve() -> Any:
        model = mujoco.MjModel.from_xml_string(text)
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
        model.dof_damping[:] = 0.0
        model.dof_frictionloss[:] = 0.0
        model.dof_armature[:] = 0.0
        # Centres of mass may leave the frames of their links.
        model.body_sameframe[:] = mujoco.mjtSameFrame.mjSAMEFRAME_NONE
        data, own = mujoco.MjData(model), friction(rows)
        links = [model.body(f"lwr_{link}_link").id for link in range(1, 8)]
        moments = [model.body_mass[link] * model.body_ipos[link] for link in links]
        inertias = np.concatenate([[model.body_mass[link], *moment] for link, moment in zip(links, moments)])
        parameters = sysid.ParameterDict()
        for name, start, bound in [("tilt", np.zeros(2), 1.0), ("inertia", inertias, 1e3), ("friction", np.zeros(21), 1e3)]:
            parameters.add(sysid.Parameter(name, start, start - bound, start + bound))

        def residual(x: Any, _parameters: Any) -> Any:
            model.opt.gravity, _ = direction(x[:2])
            for link, (mass, *moment) in zip(links, x[2:30].reshape(7, 4)):
                model.body_mass[link], model.body_ipos[link] = mass, np.array(moment) / mass
            torques = np.empty_like(rows.tau)
            for place, q in enumerate(rows.q):
                data.qpos, data.qvel, data.qacc = q, 0.0, 0.0
                mujoco.mj_inverse(model, data)
                torques[place] = data.qfrc_inverse
            return [(torques + own @ x[30:] - rows.tau).ravel()], None, None

        with contextlib.redirect_stdout(io.StringIO()):  # its iterations
            found, result = sysid.optimize(parameters, residual, optimizer="scipy")
        return rows.tau + residual(found.as_vector(), found)[0][0].reshape(rows.tau.shape)

    return solve


def by_figaroh(rows: Rows) -> Callable[[], Any]:
    from types import SimpleNamespace

    import pinocchio
    from figaroh.tools.qrdecomposition import QRDecomposer
    from figaroh.tools.regressor import build_regressor_basic, build_regressor_reduced, get_index_eliminate

    model = pinocchio.buildModelFromUrdf(str(DATA / "kuka_lwr4.urdf"))
    robot = SimpleNamespace(model=model, data=model.createData())
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])

    def solve() -> Any:
        still = np.zeros_like(rows.q)
        how = {"is_joint_torques": True, "act_idxv": range(7)}
        regressor = build_regressor_basic(robot, rows.q, still, still, how)
        # Joint after joint, in FIGAROH's order.
        own = np.moveaxis(friction(rows), 1, 0).reshape(-1, 21)
        regressor, tau = np.hstack([regressor, own]), rows.tau.T.ravel()
        names = {f"p{column}": 0.0 for column in range(regressor.shape[1])}
        eliminated, left = get_index_eliminate(regressor, names, 1e-6)
        reduced = build_regressor_reduced(regressor, eliminated)
        base, solution = QRDecomposer().decompose_with_pivoting(tau, reduced, left)[:2]
        values = np.array([float(value) for value in solution.values()])
        return (base @ values).reshape(7, -1).T

    return solve


PEERS: dict[str, Callable[[Rows], Callable[[], Any]]] = {
    "gravcal": by_gravcal,
    "scipy.optimize.least_squares": by_scipy,
    'MuJoCo sysid, optimizer="scipy"': by_mujoco,
    "FIGAROH, gravity held upright": by_figaroh,
}


def main() -> None:
    if not DATA.exists():
        print(f"SKIPPED: there is no folder {DATA}")
        return
    # It doubts that rows of a recording are poses.
    logging.getLogger("gravcal").setLevel(logging.ERROR)
    rows = recorded(int(sys.argv[1]) if len(sys.argv) > 1 else 1500)
    print(f"{len(rows.q)} rows of seven joints")
    print(f"{'':34}{'ms':>9} {'to gravcal':>10} {'rms residual, N·m':>18} {'most off gravcal, N·m':>22}")
    solvers = {}
    for name, peer in PEERS.items():
        try:
            solvers[name] = peer(rows)
        except ImportError as error:
            print(f"{name}: left out, as {error}")
    times: dict[str, list[float]] = {name: [] for name in solvers}
    predicted = {}
    for _ in range(RUNS):
        for name, solve in solvers.items():
            begun = time.perf_counter()
            predicted[name] = solve()
            times[name].append(1e3 * (time.perf_counter() - begun))
    ours = min(times["gravcal"])
    for name in solvers:
        rms = np.sqrt(np.mean((predicted[name] - rows.tau) ** 2))
        off = np.abs(predicted[name] - predicted["gravcal"]).max()
        print(f"{name:34}{min(times[name]):9.1f} {min(times[name]) / ours:10.2f} {rms:18.6f} {off:22.6f}", flush=True)


if __name__ == "__main__":
    main()
