"""FIGAROH's identification of an arm from recordings, and its prediction of another: one line of JSON.

`pip install figaroh`; then `identify.py URDF CUT_OFF_HZ HELD_OUT.csv FITTED.csv...`. As FIGAROH's own examples do: positions are filtered
and differentiated, torques are filtered alike (median of five, then Butterworth forward and backward), the regressor has friction and a bias of each
joint, columns without effect are left out, a double QR decomposition finds base parameters, and least squares weighted by joint their values.

Every row counts. Errors are those of filtered torques, N·m: root mean square by joint. `seconds` is the processor time from the files of the
fitted recordings to the parameters.
"""

import contextlib
import io
import json
import os
import sys
import tempfile
import time
import warnings
import xml.etree.ElementTree

warnings.simplefilter("ignore")
import numpy
import pandas
from scipy import signal

with contextlib.redirect_stdout(io.StringIO()):
    from figaroh.tools.load_robot import load_robot
    from figaroh.tools.qrdecomposition import QRDecomposer
    from figaroh.tools.regressor import RegressorBuilder, RegressorConfig, build_regressor_reduced, get_index_eliminate

import logging

logging.disable(logging.CRITICAL)


def robot_of(urdf):
    """The robot without its meshes, which need not be there."""
    tree = xml.etree.ElementTree.parse(urdf)
    for link in tree.getroot().iter("link"):
        for shape in link.findall("visual") + link.findall("collision"):
            link.remove(shape)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "robot.urdf")
        tree.write(path)
        with contextlib.redirect_stdout(io.StringIO()):
            return load_robot(path)


def filtered(values, rate, cut_off):
    """As `BaseIdentification._apply_filters` of FIGAROH."""
    b, a = signal.butter(4, cut_off / (rate / 2), "low")
    return numpy.column_stack([signal.filtfilt(b, a, signal.medfilt(column, 5)) for column in values.T])


def read(path, joints, cut_off):
    """Filtered positions, velocities, accelerations and torques of a recording."""
    table = pandas.read_csv(path)
    clock = table["time_s"].to_numpy()
    step = (clock[-1] - clock[0]) / (len(clock) - 1)
    q = filtered(table[[f"q{j + 1}_rad" for j in range(joints)]].to_numpy(), 1 / step, cut_off)
    tau = filtered(table[[f"tau{j + 1}_Nm" for j in range(joints)]].to_numpy(), 1 / step, cut_off)
    v = numpy.gradient(q, step, axis=0)
    return q, v, numpy.gradient(v, step, axis=0), tau


def regressor(builder, recording):
    q, v, a, _ = recording
    return builder.build_basic_regressor(q, v, a, {"act_idxv": list(range(v.shape[1]))})


def by_joint(values, joints):
    """FIGAROH stacks joint by joint."""
    return values.reshape(joints, -1)


def main():
    urdf, cut_off, held_out, fitted = sys.argv[1], float(sys.argv[2]), sys.argv[3], sys.argv[4:]
    robot = robot_of(urdf)
    joints = robot.model.nv
    config = RegressorConfig(has_friction=True, has_joint_offset=True)
    names = [f"p{k}" for k in range((10 + len(config.extra_blocks())) * joints)]
    parameters = {name: 0.0 for name in names}
    builder = RegressorBuilder(robot, config)

    start = time.process_time()
    recordings = [read(path, joints, cut_off) for path in fitted]
    matrices = [regressor(builder, recording) for recording in recordings]
    torques = [recording[3].T.reshape(-1) for recording in recordings]
    # Recordings one after the other within each joint.
    join = lambda parts: numpy.concatenate([part.reshape(joints, -1, *part.shape[1:]) for part in parts], axis=1)
    whole = join(matrices).reshape(-1, len(names))
    tau = join(torques).reshape(-1)
    eliminated, kept = get_index_eliminate(whole, parameters, 1e-6)
    reduced = build_regressor_reduced(whole, eliminated)
    base, _ = QRDecomposer()._identify_base_parameters(reduced, kept)
    columns = reduced[:, list(base)]
    phi = numpy.linalg.lstsq(columns, tau, rcond=None)[0]
    left = by_joint(tau - columns @ phi, joints)
    weights = numpy.repeat(1 / left.std(axis=1), left.shape[1])
    phi = numpy.linalg.lstsq(columns * weights[:, None], tau * weights, rcond=None)[0]
    seconds = time.process_time() - start

    rms = lambda errors: numpy.sqrt((by_joint(errors, joints) ** 2).mean(axis=1)).tolist()
    other = read(held_out, joints, cut_off)
    predicted = build_regressor_reduced(regressor(builder, other), eliminated)[:, list(base)] @ phi
    print(json.dumps({
        "seconds": seconds,
        "parameters": len(base),
        "fitted": rms(tau - columns @ phi),
        "predicted": rms(other[3].T.reshape(-1) - predicted),
    }))


main()
