"""Torques of an exported model by Pinocchio (URDF) or MuJoCo (MJCF).

`pip install pin mujoco`, then `python torques.py MODEL < samples.json`. Samples are `{"joints": [names], "samples": [[q, v, a], …]}` with q, v
and a in the order of these joints (rad or m, and their derivatives by s); what is printed is the torque (N·m or N) of each joint in each
sample, as JSON. Gravity of a URDF is 9.81 m/s² down along z of its root, unless `"gravity": [x, y, z]` is among the samples.
"""

import json
import sys

import numpy


def by_pinocchio(path, joints, samples, gravity):
    import pinocchio

    model = pinocchio.buildModelFromUrdf(path)
    if gravity is not None:
        model.gravity.linear = numpy.array(gravity)
    data = model.createData()
    # Continuous joints have two numbers each in a configuration: cosine and sine.
    places = [(model.joints[model.getJointId(name)].idx_q, model.joints[model.getJointId(name)]) for name in joints]
    torques = []
    for q, v, a in samples:
        configuration = pinocchio.neutral(model)
        velocity, acceleration = numpy.zeros(model.nv), numpy.zeros(model.nv)
        for (start, joint), position, speed, change in zip(places, q, v, a):
            if joint.nq == 2:
                configuration[start : start + 2] = [numpy.cos(position), numpy.sin(position)]
            else:
                configuration[start] = position
            velocity[joint.idx_v], acceleration[joint.idx_v] = speed, change
        torque = pinocchio.rnea(model, data, configuration, velocity, acceleration)
        torques.append([torque[joint.idx_v] for _, joint in places])
    return torques


def by_mujoco(path, joints, samples):
    import mujoco

    model = mujoco.MjModel.from_xml_path(path)
    # Limits would push back.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    places = [model.joint(name) for name in joints]
    torques = []
    for q, v, a in samples:
        for joint, position, speed, change in zip(places, q, v, a):
            data.qpos[joint.qposadr[0]], data.qvel[joint.dofadr[0]] = position, speed
            data.qacc[joint.dofadr[0]] = change
        mujoco.mj_inverse(model, data)
        torques.append([data.qfrc_inverse[joint.dofadr[0]] for joint in places])
    return torques


def main():
    path, asked = sys.argv[1], json.load(sys.stdin)
    joints, samples = asked["joints"], asked["samples"]
    if path.endswith(".urdf"):
        torques = by_pinocchio(path, joints, samples, asked.get("gravity"))
    else:
        torques = by_mujoco(path, joints, samples)
    print(json.dumps([[float(torque) for torque in sample] for sample in torques]))


main()
