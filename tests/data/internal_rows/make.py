"""Makes the components of this folder from the files of other programs that README.md names, and dense references of them.

    python make.py FOLDER_WITH_THE_FILES        (numpy, scipy, pyyeti)

The references are made by NumPy and SciPy alone: the spectrum is that of M against K + s M, because M is singular.
"""
import gzip, json, sys
from pathlib import Path
import numpy as np, scipy.linalg as la, scipy.sparse as sp

source, here = Path(sys.argv[1]), Path(__file__).parent
names = ["ux", "uy", "uz", "rx", "ry", "rz"]


def write(name, K, M, points, rows, sets, interfaces, units, cells=()):
    """`rows`: (point or None, direction) of each row of K and M."""
    for A, suffix in ((K, ""), (M, ".mass")):
        A = sp.coo_array(np.tril(A)); text = "%%MatrixMarket matrix coordinate real symmetric\n" + f"{A.shape[0]} {A.shape[1]} {A.nnz}\n"
        text += "".join(f"{i + 1} {j + 1} {v!r}\n" for i, j, v in zip(A.row.tolist(), A.col.tolist(), A.data.tolist()))
        with gzip.GzipFile(here / f"{name}{suffix}.mtx.gz", "wb", 9, mtime=0) as file:
            file.write(text.encode())
    dofs = [[None, "internal"] if p is None else [p, names[d]] for p, d in rows]
    component = {"name": name, "units": dict(zip(("length", "mass", "time"), units)), "dofs": dofs, "interfaces": interfaces}
    mesh = {"points": points, "cells": [{"type": t, "data": d} for t, d in cells], "point_sets": sets, "component": component}
    (here / f"{name}.json").write_text("{\n" + ",\n".join(f' "{k}": {json.dumps(v)}' for k, v in mesh.items()) + "\n}\n")


def reference(K, M, points, rows, L, kept):
    """Mass, centre, inertia, ω² and F_res of the rows of L with so many modes kept."""
    points = np.array(points, float); R = np.zeros((len(rows), 6))
    def rigid(about):
        for r, (p, d) in enumerate(rows):
            if p is not None and d < 3:
                x = points[p] - about; R[r, d] = 1; R[r, 3:] = [(0, x[2], -x[1]), (-x[2], 0, x[0]), (x[1], -x[0], 0)][d]
            elif p is not None:
                R[r, d] = 1
        return R
    J = rigid(np.zeros(3)).T @ M @ R; m = J[0, 0]; com = np.array([J[1, 5], J[2, 3], J[0, 4]]) / m
    J = rigid(com).T @ M @ R
    rank = int((np.linalg.eigvalsh(M) > 1e-12 * np.abs(M).max()).sum())
    s = 1e-3 * np.trace(K) / np.trace(M); mu, V = la.eigh(M, K + s * M); mu, V = mu[::-1], V[:, ::-1]
    omega2 = 1 / mu[6:rank] - s
    Rn = R @ np.linalg.inv(np.linalg.cholesky(J)).T; MR = M @ Rn
    G = la.solve(K + s * MR @ MR.T, (L - (L @ Rn) @ MR.T).T, assume_a="sym"); G -= Rn @ (MR.T @ G)
    Phi = V[:, 6:6 + max(kept)]; Phi = Phi / np.sqrt(np.einsum("ik,ij,jk->k", Phi, M, Phi)); C = L @ Phi
    F = {str(k): (L @ G - (C[:, :k] / omega2[:k]) @ C[:, :k].T).tolist() for k in kept}
    return dict(rows=len(rows), internal_rows=sum(p is None for p, _ in rows), mass_rank=rank, mass=m, centre=com.tolist(), inertia=J[3:, 3:].tolist(),
                omega2=omega2.tolist(), flexibility=F)


def average(points, rows, nodes):
    """Six rows: the frame at the centroid that fits the translations of the nodes best."""
    at = {pd: i for i, pd in enumerate(rows) if pd[0] is not None}; x = np.array(points, float)[nodes]; A = np.zeros((3 * len(nodes), 6))
    for k, v in enumerate(x - x.mean(0)):
        A[3 * k:3 * k + 3, :3] = np.eye(3); A[3 * k:3 * k + 3, 3:] = [(0, v[2], -v[1]), (-v[2], 0, v[0]), (v[1], -v[0], 0)]
    L = np.zeros((6, len(rows))); L[:, [at[n, d] for n in nodes for d in range(3)]] = np.linalg.pinv(A)
    return L


def unit_rows(rows, wanted):
    return np.array([[float(row == w) for row in rows] for w in wanted])


made = {}

# Plate of eight C3D8I by CalculiX: nine incompatible amplitudes an element, labelled as three nodes beyond the deck's largest.
stem = source / "calculix/plate_incompatible"
labels, points, hexahedra, sets, mode = {}, [], [], {}, ""
for line in open(f"{stem}.inp"):
    if line.startswith("*"):
        mode = line.strip().upper()
    elif mode.startswith("*NODE"):
        label, *x = line.split(","); labels[int(label)] = len(points); points.append([float(v) for v in x])
    elif mode.startswith("*ELEMENT"):
        hexahedra.append([labels[int(v)] for v in line.split(",")[1:]])
    elif mode.startswith("*NSET"):
        sets[mode.split("=")[1].lower()] = [labels[int(v)] for v in line.split(",")]
dofs = [tuple(map(int, line.split("."))) for line in open(f"{stem}.dof").read().split()]
rows = [(labels.get(n), d - 1) for n, d in dofs]
def triangle(extension):
    a = np.loadtxt(f"{stem}.{extension}"); A = np.zeros((len(rows),) * 2); A[a[:, 0].astype(int) - 1, a[:, 1].astype(int) - 1] = a[:, 2]
    return A + np.triu(A, 1).T
K, M = triangle("sti"), triangle("mas")
frames = [{"name": name, "kind": "average", "point_set": name} for name in ("left", "right")]
write("plate", K, M, points, rows, sets, frames, ("mm", "t", "s"), [("hexahedron", hexahedra)])
made["plate"] = reference(K, M, points, rows, np.vstack([average(points, rows, sets[n]) for n in ("left", "right")]), (0, 2, 8))

# One B33 by Abaqus: node -1 is internal.
def entries(path):
    found = [line.split(",") for line in open(path)]
    at = {label: i for i, label in enumerate(sorted({(int(e[k]), int(e[k + 1])) for e in found for k in (0, 2)}))}
    A = np.zeros((len(at),) * 2)
    for a, b, c, d, v in found:
        i, j = at[int(a), int(b)], at[int(c), int(d)]; A[i, j] = A[j, i] = float(v)
    return A, list(at)
K, at = entries(source / "abaqus/fembeam/model_STIF1.mtx"); M, _ = entries(source / "abaqus/fembeam/model_MASS1.mtx")
rows = [(None, d - 1) if n < 0 else (n - 1, d - 1) for n, d in at]; points = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
ends = [{"name": name, "kind": "nodes", "nodes": [n]} for n, name in enumerate(("first", "second"))]
write("beam", K, M, points, rows, {}, ends, ("m", "kg", "s"), [("line", [[0, 1]])])
made["beam"] = reference(K, M, points, rows, unit_rows(rows, [(n, d) for n in (0, 1) for d in range(6)]), (0, 2))

# External superelement by Nastran: four grids and 22 amplitudes of component modes; grid 11 moves along the axes of system 10.
from pyyeti.nastran import op4
matrices = op4.read(source / "nastran/pyyeti/outboard.op4")
axes = np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]])
T = la.block_diag(*[axes if k in (2, 3) else np.eye(3) for k in range(8)], np.eye(22))
K, M = (T @ np.asarray(matrices[name]) @ T.T for name in ("kxx", "mxx"))
K, M = (K + K.T) / 2, (M + M.T) / 2
points = [[600.0, 0.0, 300.0], [600.0, 300.0, 300.0], [600.0, 300.0, 0.0], [600.0, 0.0, 0.0]]
rows = [(g, d) for g in range(4) for d in range(6)] + [(None, k) for k in range(22)]
grids = [{"name": f"grid-{label}", "kind": "nodes", "nodes": [g]} for g, label in enumerate((3, 11, 19, 27))]
write("outboard", K, M, points, rows, {}, grids, ("in", "slinch", "s"), [("quad", [[0, 1, 2, 3]])])
made["outboard"] = reference(K, M, points, rows, unit_rows(rows, rows[:24]), (0, 6))

(here / "reference.json").write_text(json.dumps(made, indent=1) + "\n")
for name, of in made.items():
    print(name, of["rows"], "rows,", of["internal_rows"], "internal, rank of M", of["mass_rank"], "mass", of["mass"], "Hz", np.sqrt(of["omega2"][:3]) / 2 / np.pi)
