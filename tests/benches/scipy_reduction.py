"""The same reduction with SciPy: eigsh (shift-invert, SuperLU) and attachment columns on the same factor.

    python3 scipy_reduction.py PART.mtx MODES OUT.json

Reads PART.mtx, PART.mass.mtx and PART.json (averaged interfaces over point sets, uniform weights), computes MODES free-free
elastic modes and the residual flexibility of the interface frames, and writes what was found with the residuals.
"""
import json
import sys
import time

import fast_matrix_market as fmm
import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh, splu


def interface_columns(points, component, sets):
    """L_b^T of averaged frames: columns are unit forces and moments spread over the nodes."""
    blocks = []
    for interface in component["interfaces"]:
        nodes = np.array(sets[interface["point_set"]])
        position = np.array(interface.get("position", points[nodes].mean(0)))
        arms = points[nodes] - position
        motion = np.zeros((3 * len(nodes), 6))
        for axis in range(3):
            motion[axis::3, axis] = 1
            motion[:, 3 + axis] = np.cross(np.eye(3)[axis], arms).ravel()
        block = np.zeros((3 * len(points), 6))
        block[(3 * nodes[:, None] + np.arange(3)).ravel()] = motion @ np.linalg.inv(motion.T @ motion)
        blocks.append(block)
    return np.hstack(blocks)


def rigid_motions(points, mass):
    centred = points - points.mean(0)
    rigid = np.zeros((3 * len(points), 6))
    for axis in range(3):
        rigid[axis::3, axis] = 1
        rigid[:, 3 + axis] = np.cross(np.eye(3)[axis], centred).ravel()
    cholesky = np.linalg.cholesky(rigid.T @ (mass @ rigid))
    return np.linalg.solve(cholesky, rigid.T).T


def main(part, modes, out):
    stages, start = {}, time.perf_counter()

    def lap(name):
        nonlocal start
        stages[name] = time.perf_counter() - start
        start = time.perf_counter()

    stem = part.removesuffix(".mtx")
    stiffness = fmm.mmread(part).tocsc()
    mass = fmm.mmread(stem + ".mass.mtx").tocsc()
    description = json.load(open(stem + ".json"))
    points = np.array(description["points"])
    columns = interface_columns(points, description["component"], description["point_sets"])
    lap("read")
    rigid = rigid_motions(points, mass)
    # A tenth of a rough first bending frequency, squared: SciPy's user has to know such a number.
    length = np.ptp(points, axis=0).max()
    shift = -(0.1 * 22.4 / length**2 * np.sqrt(2.1e11 / 7850) * 0.02 / np.sqrt(12)) ** 2
    factor = splu(
        (stiffness - shift * mass).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.001,
        options=dict(SymmetricMode=True),
    )
    lap("factor")
    operator = LinearOperator(stiffness.shape, factor.solve)
    values, shapes = eigsh(stiffness, modes + 6, mass, sigma=shift, OPinv=operator, tol=1e-10)
    order = np.argsort(values)
    values, shapes = values[order][6:], shapes[:, order][:, 6:]
    shapes -= rigid @ (rigid.T @ (mass @ shapes))
    lap("modes")
    kept = np.hstack([rigid, shapes])
    mass_kept = mass @ kept
    forces = columns - mass_kept @ (kept.T @ columns)
    residual_shapes = np.zeros_like(forces)
    norms = np.linalg.norm(forces, axis=0)
    worst = np.inf
    for _ in range(12):
        residual = forces - stiffness @ residual_shapes
        before, worst = worst, (np.linalg.norm(residual, axis=0) / norms).max()
        if worst < 1e-12 or worst > 0.3 * before:  # as accurate as it gets
            break
        residual_shapes += factor.solve(residual)
        residual_shapes -= kept @ (mass_kept.T @ residual_shapes)
    flexibility = columns.T @ residual_shapes
    residual_mass = residual_shapes.T @ (mass @ residual_shapes)
    lap("attachments")
    forces_of_modes = stiffness @ shapes
    defects = np.linalg.norm(forces_of_modes - (mass @ shapes) * values, axis=0)
    json.dump(
        dict(
            frequencies=(np.sqrt(values) / 2 / np.pi).tolist(),
            mode_residual=float((defects / np.linalg.norm(forces_of_modes, axis=0)).max()),
            orthonormality=float(np.abs(shapes.T @ (mass @ shapes) - np.eye(modes)).max()),
            attachment_residual=float(worst),
            flexibility=flexibility.tolist(),
            residual_mass=residual_mass.tolist(),
            stages=stages,
        ),
        open(out, "w"),
    )


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
