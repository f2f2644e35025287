"""Writes pinocchio_dynamics.toml: what Pinocchio says of the arms in the shared data folder in motion.

    python3 -m venv venv && venv/bin/pip install pin numpy
    GRAVCAL_SHARED_DATA=<folder> venv/bin/python tests/pinocchio_dynamics.py

Run from anywhere; without GRAVCAL_SHARED_DATA the folder is `../shared/data` beside the project. The facts in the
repository were written with Pinocchio 4.1.0. Inputs are decimals of at most four places; outputs are rounded to 1e-15.

For every state: the inverse dynamics with rotor inertias (`rnea`, `armature`) under a tilted gravity, and its derivatives by
coordinates, velocities and accelerations (`computeRNEADerivatives`) and by gravity (differences of a linear function); for
the first state the regressor (`computeJointTorqueRegressor`), 10 columns a link in the order of the links. Pinocchio tells a
body in the frame of its joint; where a tip's frame is another, its columns are taken there by the pseudo-inertia.
Movable joints beyond the tips are no part of the chain: their bodies are given no mass, and stand still.

Pinocchio does not derive what mimics: each joint has a coordinate of its own there, and with θ = A q + c torques and
derivatives are multiplied by A here.
"""

import os
import pathlib
import re
import xml.etree.ElementTree

import numpy
import pinocchio

HERE = pathlib.Path(__file__).resolve().parent
DATA = pathlib.Path(os.environ.get("GRAVCAL_SHARED_DATA", HERE.parents[3] / "shared" / "data"))

# File, base, tips: branches in the order of the chain.
ROBOTS = [
    ("urdf/panda_arm_drake.urdf", "panda_link0", ["panda_link8"]),
    ("urdf/panda_example-robot-data.urdf", "panda_link0", ["panda_hand"]),
    # Two sliding fingers on one hand, the second of which mimics the first.
    ("urdf/panda_example-robot-data.urdf", "panda_link0", ["panda_leftfinger", "panda_rightfinger"]),
    ("urdf/iiwa14_no_collision_drake.urdf", "base", ["iiwa_link_ee"]),
    ("urdf/kinova_gen3_7dof_v12.urdf", "base_link", ["end_effector_link"]),
    ("urdf/ur5e_ros-industrial.urdf", "base_link", ["tool0"]),
    ("urdf/ur10e_ros-industrial.urdf", "base_link_inertia", ["tool0"]),
    ("urdf/ur10_example-robot-data.urdf", "world", ["tool0"]),
    ("urdf/z1_example-robot-data.urdf", "world", ["gripperMover"]),
    ("kuka_lwr4/kuka_lwr4.urdf", "box", ["lwr_7_link"]),
    # A sliding trunk with head, laser, an arm to the palm, and an arm to its four fingers, of which three mimic the first.
    (
        "urdf/pr2_example-robot-data.urdf",
        "base_link",
        [
            "wide_stereo_link",
            "laser_tilt_link",
            "r_gripper_tool_frame",
            "l_gripper_l_finger_tip_link",
            "l_gripper_r_finger_tip_link",
            "l_gripper_l_parallel_link",
            "l_gripper_r_parallel_link",
        ],
    ),
]
GRAVITY = [-3.43, -5.94, -7.0]
STATES = 2


class Arm:
    """The model with a coordinate for each joint, those between root and tips, and who follows whom."""

    def __init__(self, file, base, tips):
        # Friction is no part of `rnea`, and Pinocchio refuses a negative one.
        text = re.sub(r"<dynamics[^>]*/>", "", (DATA / file).read_text(encoding="utf-8"))
        self.model = pinocchio.buildModelFromXML(text)
        self.data = self.model.createData()
        model = self.model
        self.frames = {}
        links = []
        for tip in tips:
            frame = model.frames[model.getFrameId(tip)]
            links += [joint for joint in model.supports[frame.parentJoint] if joint != 0 and joint not in links]
            self.frames[frame.parentJoint] = frame.placement
        self.links = links
        for joint in range(1, model.njoints):
            if joint not in links:
                model.inertias[joint] = pinocchio.Inertia.Zero()
        mimics = {
            joint.get("name"): joint.find("mimic").attrib
            for joint in xml.etree.ElementTree.fromstring(text).iter("joint")
            if joint.find("mimic") is not None
        }
        names = [model.names[joint] for joint in links]
        self.joints = [name for name in names if name not in mimics]
        self.spread, self.shift = numpy.zeros((len(names), len(self.joints))), numpy.zeros(len(names))
        for row, name in enumerate(names):
            mimic = mimics.get(name, {"joint": name})
            self.spread[row, self.joints.index(mimic["joint"])] = float(mimic.get("multiplier", 1.0))
            self.shift[row] = float(mimic.get("offset", 0.0))
        self.velocities = [model.joints[joint].idx_v for joint in links]
        pinocchio.framesForwardKinematics(model, self.data, pinocchio.neutral(model))
        self.world_base = self.data.oMf[model.getFrameId(base)].rotation.copy()

    def state(self, coordinates, velocities, accelerations):
        """Pinocchio's q (a continuous joint has two entries, cosine and sine), v and a."""
        q = pinocchio.neutral(self.model)
        for joint, angle in zip(self.links, self.spread @ coordinates + self.shift):
            start = self.model.joints[joint].idx_q
            if self.model.joints[joint].nq == 2:
                q[start : start + 2] = [numpy.cos(angle), numpy.sin(angle)]
            else:
                q[start] = angle
        v, a = numpy.zeros(self.model.nv), numpy.zeros(self.model.nv)
        v[self.velocities], a[self.velocities] = self.spread @ velocities, self.spread @ accelerations
        return q, v, a

    def torque(self, state, gravity):
        # Pinocchio's gravity is in its world, which the base may be turned in.
        self.model.gravity.linear = self.world_base @ numpy.array(gravity)
        return self.spread.T @ pinocchio.rnea(self.model, self.data, *state)[self.velocities]

    def both(self, matrix):
        return self.spread.T @ matrix[numpy.ix_(self.velocities, self.velocities)] @ self.spread

    def regressor(self, state):
        full = pinocchio.computeJointTorqueRegressor(self.model, self.data, *state)[self.velocities]
        blocks = []
        for joint in self.links:
            block = full[:, 10 * (joint - 1) : 10 * joint]
            blocks.append(block @ seen_from(self.frames[joint]) if joint in self.frames else block)
        return self.spread.T @ numpy.hstack(blocks)


def seen_from(placement):
    """The matrix that takes the ten numbers of a body in a frame to those in the frame in which this one has the placement."""
    columns = [numbers(placement.homogeneous @ pseudo(unit) @ placement.homogeneous.T) for unit in numpy.eye(10)]
    return numpy.array(columns).T


def pseudo(parameters):
    mass, x, y, z, xx, xy, yy, xz, yz, zz = parameters
    tensor = numpy.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    moment = numpy.array([[x], [y], [z]])
    return numpy.block([[0.5 * numpy.trace(tensor) * numpy.eye(3) - tensor, moment], [moment.T, numpy.array([[mass]])]])


def numbers(matrix):
    second = matrix[:3, :3]
    tensor = numpy.trace(second) * numpy.eye(3) - second
    return [matrix[3, 3], *matrix[:3, 3], tensor[0, 0], tensor[0, 1], tensor[1, 1], tensor[0, 2], tensor[1, 2], tensor[2, 2]]


def facts_of_state(arm, inputs, with_regressor):
    state = arm.state(*inputs)
    facts = dict(zip(("coordinates", "velocities", "accelerations"), inputs))
    still = arm.torque(state, [0.0, 0.0, 0.0])
    facts["torque"] = arm.torque(state, GRAVITY)
    facts["by_gravity"] = numpy.array([arm.torque(state, axis) - still for axis in numpy.eye(3)]).T
    arm.torque(state, GRAVITY)
    derivatives = pinocchio.computeRNEADerivatives(arm.model, arm.data, *state)
    for name, derivative in zip(("coordinate", "velocity", "acceleration"), derivatives):
        facts["by_" + name] = arm.both(derivative)
    if with_regressor:
        facts["by_parameters"] = arm.regressor(state)
    return facts


def toml(value):
    if numpy.ndim(value) == 0:
        # Adding zero makes a negative zero a positive one.
        return repr(round(float(value), 15) + 0.0)
    return "[" + ", ".join(toml(entry) for entry in value) + "]"


def main():
    random = numpy.random.default_rng(2026)
    decimals = lambda width, count: numpy.round(random.uniform(-width, width, count), 4)
    lines = ["# Written by pinocchio_dynamics.py; its head says how. N·m, m, rad, s; matrices by rows."]
    lines += [f"gravity = {toml(GRAVITY)}"]
    for file, base, tips in ROBOTS:
        arm = Arm(file, base, tips)
        n = len(arm.joints)
        rotors = numpy.abs(decimals(1.0, n))
        for joint, inertia in zip(arm.joints, rotors):
            arm.model.armature[arm.model.joints[arm.model.getJointId(joint)].idx_v] = inertia
        quoted = lambda names: ", ".join(f'"{name}"' for name in names)
        lines += ["", "[[robot]]", f'file = "{file}"', f'base = "{base}"', f"tips = [{quoted(tips)}]"]
        lines += [f"joints = [{quoted(arm.joints)}]", f"rotor_inertia = {toml(rotors)}"]
        for index in range(STATES):
            facts = facts_of_state(arm, [decimals(3.0, n), decimals(2.0, n), decimals(5.0, n)], index == 0)
            lines += ["", "[[robot.state]]"] + [f"{key} = {toml(value)}" for key, value in facts.items()]
    (HERE / "pinocchio_dynamics.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")


main()
