"""Pinocchio's inverse dynamics of seven revolute joints, called from Python: microseconds a sample as one line of JSON.

`pip install pin numpy`. Each time is that of a loop of calls, the calls from Python included; a function that does next to
nothing tells what such a call takes (`call`).
"""

import json
import time

import numpy
import pinocchio

SAMPLES = 2000
RUNS = 9


def seven_joints():
    """Axes in turn across each other, 0.2 m apart, as on common arms."""
    model = pinocchio.Model()
    parent = 0
    for joint in range(7):
        turn = pinocchio.utils.rotate("x", numpy.pi / 2 * (-1) ** joint)
        placement = pinocchio.SE3(turn, numpy.array([0.0, 0.2, 0.05]))
        parent = model.addJoint(parent, pinocchio.JointModelRZ(), placement, f"joint{joint}")
        model.appendBodyToJoint(parent, pinocchio.Inertia.Random(), pinocchio.SE3.Identity())
    return model


def microseconds(run, samples):
    """Median processor time a sample."""
    times = []
    for _ in range(RUNS):
        start = time.process_time()
        for sample in samples:
            run(*sample)
        times.append(time.process_time() - start)
    return 1e6 * sorted(times)[RUNS // 2] / len(samples)


def main():
    model = seven_joints()
    data = model.createData()
    random = numpy.random.default_rng(1)
    samples = [tuple(random.uniform(-3.0, 3.0, (3, 7))) for _ in range(SAMPLES)]
    programs = {
        "torque": lambda q, v, a: pinocchio.rnea(model, data, q, v, a),
        "regressor": lambda q, v, a: pinocchio.computeJointTorqueRegressor(model, data, q, v, a),
        "derivatives": lambda q, v, a: pinocchio.computeRNEADerivatives(model, data, q, v, a),
        "call": lambda q, v, a: pinocchio.neutral(model),
    }
    print(json.dumps({name: microseconds(run, samples) for name, run in programs.items()}))


main()
