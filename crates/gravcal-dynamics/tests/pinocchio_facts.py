"""Writes pinocchio_facts.toml: what Pinocchio says of the arms in the shared data folder.

    python3 -m venv venv && venv/bin/pip install pin numpy
    GRAVCAL_SHARED_DATA=<folder> venv/bin/python tests/pinocchio_facts.py

Run from anywhere; without GRAVCAL_SHARED_DATA the folder is `../shared/data` beside the project. The facts in the
repository were written with Pinocchio 4.1.0. Inputs are decimals of at most four places; outputs are printed with
the fewest digits (up to 17) that read back to the same bits.

For every pose: the last tip's pose in base coordinates, the generalized gravity under an upright and a tilted gravity, and
for the first poses its derivative by the coordinates under the tilted one. Movable joints beyond the tips are no part of
the chain: their bodies are given no mass here. Of joints that mimic others Pinocchio knows the gravity, but not its
derivative.
"""

import os
import pathlib
import re

import numpy
import pinocchio

HERE = pathlib.Path(__file__).resolve().parent
DATA = pathlib.Path(os.environ.get("GRAVCAL_SHARED_DATA", HERE.parents[3] / "shared" / "data"))

# File, base, tips. Bases are root links but for three that fixed joints turn or shift.
ROBOTS = [
    ("urdf/panda_arm_drake.urdf", "panda_link0", ["panda_link8"]),
    ("urdf/panda_example-robot-data.urdf", "panda_link0", ["panda_hand"]),
    ("urdf/iiwa14_no_collision_drake.urdf", "base", ["iiwa_link_ee"]),
    ("urdf/kinova_gen3_7dof_v12.urdf", "base_link", ["end_effector_link"]),
    ("urdf/ur5e_ros-industrial.urdf", "base_link", ["tool0"]),
    ("urdf/ur10e_ros-industrial.urdf", "base_link_inertia", ["tool0"]),
    ("kuka_lwr4/kuka_lwr4.urdf", "box", ["lwr_7_link"]),
    ("kuka_lwr4/kuka_lwr4_gaz.urdf", "world", ["lwr_7_link"]),
    ("kuka_lwr4/kuka_lwr4_identified.urdf", "lwr_base_link", ["lwr_7_link"]),
    ("kuka_lbr_med7/med7dock.urdf", "link_0", ["link_shaft"]),
    # Two fingers on one hand, the second of which mimics the first.
    ("urdf/panda_example-robot-data.urdf", "panda_link0", ["panda_leftfinger", "panda_rightfinger"]),
]
UPRIGHT = [0.0, 0.0, -9.81]
TILTED = [-3.43, -5.94, -7.0]
POSES = 5
POSES_WITH_DERIVATIVE = 2
DECIMALS = 4


def arm(file, tips):
    """The model, its data, and the joints between root and tips, proximal first; nothing beyond them has mass.

    Of the joints, those that mimic another have no coordinate of their own: they are not among the last list.
    """
    # Gravity has no friction in it, and Pinocchio refuses the negative one of kuka_lwr4_identified.urdf.
    text = re.sub(r"<dynamics[^>]*/>", "", (DATA / file).read_text(encoding="utf-8"))
    model = pinocchio.buildModelFromXML(text, len(tips) > 1)
    tip_joints = [model.frames[model.getFrameId(tip)].parentJoint for tip in tips]
    joints = list(dict.fromkeys(joint for tip in tip_joints for joint in model.supports[tip] if joint != 0))
    for joint in range(1, model.njoints):
        if joint not in joints:
            model.inertias[joint] = pinocchio.Inertia.Zero()
    return model, model.createData(), [joint for joint in joints if model.joints[joint].nv > 0]


def configuration(model, joints, coordinates):
    """Pinocchio's q: a continuous joint has two entries, cosine and sine."""
    q = pinocchio.neutral(model)
    for joint, coordinate in zip(joints, coordinates):
        start = model.joints[joint].idx_q
        if model.joints[joint].nq == 2:
            q[start : start + 2] = [numpy.cos(coordinate), numpy.sin(coordinate)]
        else:
            q[start] = coordinate
    return q


def frame_pose(model, data, q, name):
    pinocchio.framesForwardKinematics(model, data, q)
    return data.oMf[model.getFrameId(name)].copy()


def facts_of_pose(model, data, joints, base, tip, coordinates, with_derivative):
    q = configuration(model, joints, coordinates)
    velocities = [model.joints[joint].idx_v for joint in joints]
    world_base = frame_pose(model, data, q, base)
    base_tip = world_base.actInv(frame_pose(model, data, q, tip))
    facts = {
        "coordinates": coordinates,
        "tip_position": base_tip.translation,
        "tip_rotation": base_tip.rotation,
    }
    for name, gravity in (("upright", UPRIGHT), ("tilted", TILTED)):
        # Pinocchio's gravity is in its world, which the base may be turned in.
        model.gravity.linear = world_base.rotation @ numpy.array(gravity)
        torque = pinocchio.computeGeneralizedGravity(model, data, q)
        facts["torque_" + name] = torque[velocities]
    if with_derivative:
        derivative = pinocchio.computeGeneralizedGravityDerivatives(model, data, q)
        facts["by_coordinate_tilted"] = derivative[numpy.ix_(velocities, velocities)]
    return facts


def toml(value):
    if numpy.ndim(value) == 0:
        return repr(float(value))
    return "[" + ", ".join(toml(entry) for entry in value) + "]"


def main():
    random = numpy.random.default_rng(1994)
    lines = ["# Written by pinocchio_facts.py; its head says how. N·m, m, rad, m/s²; matrices by rows."]
    lines += [f"gravity_upright = {toml(UPRIGHT)}", f"gravity_tilted = {toml(TILTED)}"]
    for file, base, tips in ROBOTS:
        model, data, joints = arm(file, tips)
        tip_names = ", ".join(f'"{tip}"' for tip in tips)
        names = ", ".join(f'"{model.names[joint]}"' for joint in joints)
        lines += ["", "[[robot]]", f'file = "{file}"', f'base = "{base}"', f"tips = [{tip_names}]", f"joints = [{names}]"]
        for pose in range(POSES):
            coordinates = numpy.round(random.uniform(-3.0, 3.0, len(joints)), DECIMALS)
            facts = facts_of_pose(
                model, data, joints, base, tips[-1], coordinates, pose < POSES_WITH_DERIVATIVE and len(tips) == 1
            )
            lines += ["", "[[robot.pose]]"] + [f"{key} = {toml(value)}" for key, value in facts.items()]
    (HERE / "pinocchio_facts.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")


main()
