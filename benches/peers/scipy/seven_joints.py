"""The joint problem of seven joints with NumPy and scipy.optimize.least_squares: all poses at once, analytic Jacobian.

    y_i = k_i tau_i + b_i,     theta_j = s_j q_j + o_j,     tau_i = (z_i x g) . M_i

z_i and o_i are direction and point of axis i in base coordinates, M_i the first moment about o_i of all that joint i
carries. Gravity and the displacement move on their spheres, by two coordinates around the start each.

Reads the folder that benches/speed/exchange.rs describes, finds the fewest evaluations that lead from the start there to
the cosine wanted, solves with as many several times, and prints one line of JSON: median processor time of least_squares
in s, iterations, cost at the start and at the end, largest cosine at the end.
"""

import csv
import json
import sys
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

JOINTS = 7
COSINE = 1e-8
RUNS = 5
MOST_EVALUATIONS = 50
# Columns of the Jacobian.
GRAVITY, GAIN, BIAS = slice(0, 2), slice(2, 9), slice(9, 16)
POSITION_GAIN, OFFSET, INERTIA = slice(16, 23), slice(23, 28), slice(28, 56)
PLACEMENT, DIRECTION = slice(56, 59), slice(59, 61)


class Sphere:
    """Vectors as long as `start`: from there along the great circle in the direction B u, by the angle |u|."""

    def __init__(self, start):
        self.length = np.linalg.norm(start)
        self.start = start / self.length
        self.basis = np.linalg.svd(start[None, :])[2][1:].T

    def at(self, u):
        """The vector, and its derivative by u (3 x 2)."""
        angle, along = np.linalg.norm(u), self.basis @ u
        sinc = np.sinc(angle / np.pi)
        bend = (np.cos(angle) - sinc) / angle**2 if angle > 1e-4 else -1 / 3
        vector = np.cos(angle) * self.start + sinc * along
        derivative = sinc * self.basis + np.outer(bend * along - sinc * self.start, u)
        return self.length * vector, self.length * derivative


class Sweep:
    """One evaluation: axes and links outward, moments inward. A vector is three rows, with a column a pose."""

    def __init__(self, problem, x):
        self.gravity, self.by_tilt = problem.gravity.at(x[GRAVITY])
        displacement, self.by_direction = problem.displacement.at(x[DIRECTION])
        self.place(problem, x)
        position = x[PLACEMENT, None] + displacement[:, None] * problem.displaced
        self.gather(x[INERTIA].reshape(JOINTS, 4), problem.load, problem.load * position)
        self.levers = [cross(z, self.gravity) for z in self.axes]
        self.torque = np.array([dot(w, m) for w, m in zip(self.levers, self.moments)])

    def place(self, problem, x):
        c, offset = problem.constants, problem.constants["position_offset"].copy()
        offset[1:-1] = x[OFFSET]
        angle = x[POSITION_GAIN, None] * problem.position + offset[:, None]
        cosine, sine = np.cos(angle), np.sin(angle)
        ex, ey, ez = (np.repeat(axis[:, None], angle.shape[1], 1) for axis in np.eye(3))
        origin = np.zeros_like(ex)
        self.axes, self.points, self.links, self.origins = [], [], [], []
        for i, (a, d, ca, sa) in enumerate(zip(c["dh_a"], c["dh_d"], c["dh_cos_alpha"], c["dh_sin_alpha"])):
            self.axes.append(ez)
            self.points.append(origin)
            ex, ey = ex * cosine[i] + ey * sine[i], ey * cosine[i] - ex * sine[i]
            origin = origin + a * ex + d * ez
            ey, ez = ca * ey + sa * ez, ca * ez - sa * ey
            self.links.append((ex, ey, ez))
            self.origins.append(origin)

    def gather(self, inertia, mass, load_moment):
        about, moment = self.origins[-1], turned(self.links[-1], load_moment)
        self.moments = []
        for point, link, origin, (m, *h) in reversed(list(zip(self.points, self.links, self.origins, inertia))):
            moment = moment + (about - point) * mass + (origin - point) * m + turned(link, h)
            mass, about = mass + m, point
            self.moments.insert(0, moment)


class Problem:
    def __init__(self, folder):
        with open(folder / "constants.csv") as file:
            self.constants = c = {name: np.array(numbers, float) for name, *numbers in csv.reader(file)}
        poses = np.loadtxt(folder / "poses.csv", delimiter=",", unpack=True)
        self.position, self.reading = poses[1:8], poses[8:15]
        self.load, self.displaced = c["load_mass"] * (poses[0] > 0), poses[0] == 2
        self.gravity, self.displacement = Sphere(c["gravity"]), Sphere(c["displacement"])
        self.weight = 1 / c["torque_std"]
        at_start = np.zeros(2)
        self.start = np.concatenate([at_start, c["torque_gain"], c["torque_bias"], c["position_gain"],
                                     c["position_offset"][1:-1], c["inertia"], c["placement"], at_start])

    def residual(self, x):
        """Prediction less measurement in standard deviations, joint after joint."""
        predicted = x[GAIN, None] * Sweep(self, x).torque + x[BIAS, None]
        return (self.weight[:, None] * (predicted - self.reading)).ravel()

    def jacobian(self, x):
        sweep, poses = Sweep(self, x), self.position.shape[1]
        jacobian = np.zeros((JOINTS * poses, len(x)), order="F")
        rows = [jacobian[i * poses:(i + 1) * poses] for i in range(JOINTS)]
        scale = x[GAIN] * self.weight
        for i, row in enumerate(rows):
            row[:, GRAVITY] = scale[i] * cross(sweep.moments[i], sweep.axes[i]).T @ sweep.by_tilt
            row[:, GAIN.start + i] = self.weight[i] * sweep.torque[i]
            row[:, BIAS.start + i] = self.weight[i]
            self.by_inertia(row, scale[i] * sweep.levers[i], i, sweep)
        self.by_coordinates(rows, scale, sweep)
        return jacobian

    def by_inertia(self, row, w, i, sweep):
        for k in range(i, JOINTS):
            column = INERTIA.start + 4 * k
            row[:, column] = dot(w, sweep.origins[k] - sweep.points[i])
            for axis in range(3):
                row[:, column + 1 + axis] = dot(w, sweep.links[k][axis])
        row[:, PLACEMENT] = self.load[:, None] * row[:, INERTIA.stop - 3:INERTIA.stop]
        row[:, DIRECTION] = self.displaced[:, None] * row[:, PLACEMENT] @ sweep.by_direction

    def by_coordinates(self, rows, scale, sweep):
        """The second derivative of the energy, hence symmetric in the joints."""
        rates = [cross(z, m) for z, m in zip(sweep.axes, sweep.moments)]
        for i in range(JOINTS):
            for j in range(i, JOINTS):
                second = dot(sweep.levers[i], rates[j])
                for a, b in {(i, j), (j, i)}:
                    by_coordinate = scale[a] * second
                    rows[a][:, POSITION_GAIN.start + b] = by_coordinate * self.position[b]
                    if 0 < b < JOINTS - 1:
                        rows[a][:, OFFSET.start + b - 1] = by_coordinate


def cross(a, b):
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def turned(axes, vector):
    return axes[0] * vector[0] + axes[1] * vector[1] + axes[2] * vector[2]


def largest_cosine(residual, jacobian):
    """Largest |cosine| between the residual and a column of J; columns of nothing but rounding errors do not count."""
    norms = np.linalg.norm(jacobian, axis=0)
    real = norms > 1e-12 * norms.max()
    return np.max(np.abs(residual @ jacobian)[real] / norms[real]) / np.linalg.norm(residual)


def solve(problem, residual, jacobian, evaluations):
    # "lm" (MINPACK) takes a tenth of the time of "trf", which decomposes J into singular values.
    return least_squares(residual, problem.start, jacobian, method="lm", x_scale="jac", ftol=1e-15, xtol=1e-15,
                         gtol=1e-15, max_nfev=evaluations)


class Found(Exception):
    """The cosine is small enough."""


def evaluations_needed(problem):
    """The fewest evaluations of the residual after which the cosine is small enough."""
    evaluations = 0

    def residual(x):
        nonlocal evaluations
        evaluations += 1
        return problem.residual(x)

    def jacobian(x):
        at_x = problem.jacobian(x)
        if largest_cosine(problem.residual(x), at_x) <= COSINE:
            raise Found
        return at_x

    try:
        solve(problem, residual, jacobian, MOST_EVALUATIONS)
    except Found:
        pass
    return evaluations


def median_run(problem, evaluations):
    """Processor time, solution and its cosine, of the run of median time."""
    runs = []
    for _ in range(RUNS):
        begin = time.process_time()
        solution = solve(problem, problem.residual, problem.jacobian, evaluations)
        runs.append((time.process_time() - begin, solution))
    seconds, solution = sorted(runs, key=lambda run: run[0])[RUNS // 2]
    return seconds, solution, largest_cosine(solution.fun, problem.jacobian(solution.x))


def main():
    problem = Problem(Path(sys.argv[1]))
    evaluations = evaluations_needed(problem)
    seconds, solution, cosine = median_run(problem, evaluations)
    # Sums of NumPy depend on where the memory lies, and undetermined directions enlarge that: runs differ.
    while cosine > COSINE and evaluations < MOST_EVALUATIONS:
        evaluations += 1
        seconds, solution, cosine = median_run(problem, evaluations)
    initial = problem.residual(problem.start)
    print(json.dumps({
        "seconds": seconds,
        "iterations": evaluations - 1,
        "initial_cost": 0.5 * float(initial @ initial),
        "cost": float(solution.cost),
        "cosine": float(cosine),
    }))


main()
