#!/usr/bin/env python3
"""What a user of numpy would write instead: a calibration and an exchange, for comparison of times.

    python3 benches/peer.py calibrate mechanisms/table5.toml examples/data/hardpoint-noisy.csv
    python3 benches/peer.py exchange mechanisms/table5.toml 20 2000

The calibration is Gauss-Newton with forward kinematics of all poses at once, covariance and five folds. The exchange
replaces one pose after the other by the best candidate for det(J'J), from one random start, on random poses of the
workspace; rows are divided by the noise. Needs numpy and scipy.
"""

import csv
import sys
import time
import tomllib

import numpy as np
from scipy.spatial.transform import Rotation


def mechanism(path):
    with open(path, "rb") as file:
        m = tomllib.load(file)
    a, b = (1e-3 * np.array([leg[key] for leg in m["leg"]]) for key in ("platform", "base"))
    length = 1e-3 * np.array([leg["length"] for leg in m["leg"]])
    sigma = np.repeat([1e-3 * m["noise"]["position"], np.radians(m["noise"]["rotation"])], 3)
    half = np.concatenate([1e-3 * np.array(m["workspace"]["position"]), np.radians(m["workspace"]["rotation"])])
    return np.concatenate([a.ravel(), b.ravel(), np.zeros(6)]), length, sigma, half


def closure(c, t, R):
    """Leg vectors, unit vectors and the Jacobian along small motions, for n poses."""
    a, b = c[:18].reshape(6, 3), c[18:36].reshape(6, 3)
    arm = np.einsum("nij,lj->nli", R, a)
    leg = t[:, None] + arm - b
    length = np.linalg.norm(leg, axis=2)
    u = leg / length[..., None]
    return length, u, np.concatenate([u, np.cross(arm, u)], axis=2)


def forward(c, lengths, t, R):
    for _ in range(30):
        length, _, J = closure(c, t, R)
        step = np.linalg.solve(J, (lengths + c[36:] - length)[..., None])[..., 0]
        t = t + step[:, :3]
        R = Rotation.from_rotvec(step[:, 3:]).as_matrix() @ R
        if np.abs(step).max() < 1e-9:
            return t, R
    raise ArithmeticError("forward kinematics does not converge")


def blocks(c, t, R, sigma):
    """Whitened change of the pose per unit of each of the 42 parameters, n x 6 x 42."""
    _, u, J = closure(c, t, R)
    rows = np.zeros((len(t), 6, 42))
    for leg in range(6):
        rows[:, leg, 3 * leg : 3 * leg + 3] = -np.einsum("nji,nj->ni", R, u[:, leg])
        rows[:, leg, 18 + 3 * leg : 21 + 3 * leg] = u[:, leg]
        rows[:, leg, 36 + leg] = 1.0
    return np.linalg.solve(J, rows) / sigma[:, None]


def calibrate(c, lengths, measured, sigma, start):
    pose = np.repeat(start[0][None], len(lengths), 0), np.repeat(start[1][None], len(lengths), 0)
    for _ in range(20):
        pose = forward(c, lengths, *pose)
        turn = Rotation.from_matrix(pose[1] @ measured[1].transpose(0, 2, 1)).as_rotvec()
        residual = np.concatenate([pose[0] - measured[0], turn], axis=1) / sigma
        J = blocks(c, *pose, sigma).reshape(-1, 42)
        step = np.linalg.lstsq(J, residual.ravel(), rcond=None)[0]
        c = c - step
        if np.linalg.norm(J @ step) < 1e-6:
            return c, J, residual
    raise ArithmeticError("the calibration does not converge")


def run_calibration(path, table):
    c, length, sigma, _ = mechanism(path)
    with open(table) as file:
        rows = np.array(list(csv.reader(line for line in file if line[0] != "#"))[1:], dtype=float)
    lengths, t = 1e-3 * rows[:, :6], 1e-3 * rows[:, 6:9]
    # Fixed axes x, y, z in this order; the parameters hold lengths relative to the commanded ones.
    measured = t, Rotation.from_euler("xyz", rows[:, 9:12], degrees=True).as_matrix()
    start = np.array([0.0, 0.0, np.sqrt(length[0] ** 2 - np.sum((c[:2] - c[18:20]) ** 2))]), np.eye(3)
    found, J, residual = calibrate(c, lengths, measured, sigma, start)
    spread = np.sqrt(np.diag(np.linalg.pinv(J.T @ J)))
    held = []
    order = np.random.default_rng(0).permutation(len(rows))
    for fold in range(5):
        out = order[fold::5]
        kept = np.setdiff1d(order, out)
        other, _, _ = calibrate(c, lengths[kept], (measured[0][kept], measured[1][kept]), sigma, start)
        pose = forward(other, lengths[out], measured[0][out], measured[1][out])
        held.append(np.sum((pose[0] - measured[0][out]) ** 2, axis=1))
    rms = np.sqrt(np.mean(np.concatenate(held)))
    fitted = np.sqrt(np.mean(np.sum((residual[:, :3] * sigma[0]) ** 2, axis=1)))
    print(f"{len(rows)} poses: {1e6 * fitted:.2f} um (fitted), {1e6 * rms:.2f} um (held out); "
          f"sigma of a parameter {1e6 * spread.min():.1f} to {1e6 * spread.max():.1f} um")


def run_exchange(path, poses, candidates):
    c, length, sigma, half = mechanism(path)
    rng = np.random.default_rng(1)
    home = np.sqrt(length[0] ** 2 - np.sum((c[:2] - c[18:20]) ** 2))
    q = half * rng.uniform(-1, 1, (candidates, 6)) + [0, 0, home, 0, 0, 0]
    J = blocks(c, q[:, :3], Rotation.from_euler("xyz", q[:, 3:]).as_matrix(), sigma)
    J /= np.sqrt(np.mean(J**2, axis=(0, 1)))
    chosen = list(rng.choice(candidates, poses, replace=False))
    M = np.einsum("nij,nik->jk", J[chosen], J[chosen])
    improved = True
    while improved:
        improved = False
        for place in range(poses):
            without = M - J[chosen[place]].T @ J[chosen[place]]
            V = np.linalg.inv(without + 1e-12 * np.trace(without) * np.eye(42))
            gain = np.linalg.det(np.eye(6) + J @ V @ J.transpose(0, 2, 1))
            gain[[k for k in chosen if k != chosen[place]]] = 0
            best = int(np.argmax(gain))
            if gain[best] > gain[chosen[place]] * (1 + 1e-9):
                chosen[place], improved = best, True
            M = without + J[chosen[place]].T @ J[chosen[place]]
    print(f"{poses} of {candidates} poses: log det {np.linalg.slogdet(M)[1]:.4f}")


if __name__ == "__main__":
    begin = time.perf_counter()
    if sys.argv[1:2] == ["calibrate"] and len(sys.argv) == 4:
        run_calibration(*sys.argv[2:])
    elif sys.argv[1:2] == ["exchange"] and len(sys.argv) == 5:
        run_exchange(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
    else:
        sys.exit(__doc__)
    print(f"{time.perf_counter() - begin:.2f} s")
