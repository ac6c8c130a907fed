"""Stress in the fillet of a bracket: the superelement against the whole finite-element model, with and without attachments.

    pip install numpy scipy h5py
    python3 tests/benches/stress.py [--cells 4] [--write [FILE]]

The bracket of the samples is held at its wall; a force acts at its tip, along each axis in turn, at rest and at three frequencies. The whole model is solved by SciPy (SuperLU), interfaces and all;
the superelement's equations are put together here from its file, with NumPy alone. Errors are the largest over all places, components and forces, as a part of the largest stress.
The bound is that of `reduce inspect`, for a free bracket. One JSON line each; `--write` puts them into docs/data/stress.jsonl or FILE. `--example render_pages` renders the page.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np
import scipy
import scipy.io
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.path.join(ROOT, "docs", "data", "stress.jsonl")
BINARIES = os.path.join(ROOT, "target", "release")
MODES = [0, 5, 10, 20, 40]
HERTZ = [0.0, 300.0, 2000.0, 6000.0]


def run(program, *arguments, folder):
    done = subprocess.run([os.path.join(BINARIES, program), *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return done.stdout


def average_rows(points, nodes, position, dofs):
    """Frame motion that fits the nodes' translations best."""
    count = len(nodes)
    arm = points[nodes] - position
    fit = np.zeros((3 * count, 6))
    for i, (x, y, z) in enumerate(arm):
        fit[3 * i:3 * i + 3] = [[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]]
    inverse = np.linalg.pinv(fit)
    columns = (3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()
    return sp.csr_matrix((inverse.ravel(), (np.repeat(np.arange(6), 3 * count), np.tile(columns, 6))), shape=(6, dofs))


def whole_stress(k, m, s, wall, tip, omega):
    """Stress by unit forces at the tip, (rows, 3), the wall held."""
    scale = 1e9
    dynamic = sp.bmat([[k - omega**2 * m, scale * wall.T], [scale * wall, sp.csr_matrix((6, 6))]], format="csr")
    loads = np.zeros((dynamic.shape[0], 3))
    loads[:k.shape[0]] = tip[:3].T.toarray()
    lu = scipy.sparse.linalg.splu(dynamic.tocsc())
    return s @ lu.solve(loads)[:k.shape[0]]


def reduced_stress(file, omega, attachments):
    shapes, squares = file["modes/interface_shapes"][()], file["modes/eigenvalues"][()]
    rigid = file["error/rigid_shapes"][()]
    flexibility, mass = file["residual/flexibility"][()], file["residual/mass"][()]
    stress = file["stress/shapes"][()]
    n_r, n_k, n_b = rigid.shape[1], len(squares), len(flexibility)
    blocks_k = [np.zeros((n_r, n_r)), np.diag(squares)] + ([flexibility] if attachments else [])
    blocks_m = [np.eye(n_r), np.eye(n_k)] + ([mass] if attachments else [])
    seen = np.hstack([rigid, shapes] + ([flexibility] if attachments else []))
    k, m = scipy.linalg.block_diag(*blocks_k), scipy.linalg.block_diag(*blocks_m)
    n = len(k)
    # Attachments are forces, other coordinates sqrt(mass) times length: about equal diagonals.
    unit = 1 / np.sqrt(np.abs(np.diag(k)) + np.abs(np.diag(m)) * 1e6)
    dynamic = unit[:, None] * (k - omega**2 * m) * unit
    held = seen[:6] * unit
    # The least change where the coordinates depend on each other.
    null = scipy.linalg.null_space(held)
    inside = null.T @ dynamic @ null
    y = unit[:, None] * (null @ np.linalg.lstsq(inside, null.T @ (seen[6:9] * unit).T, rcond=1e-13)[0])
    return stress[:, :n - n_r] @ y[n_r:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=4)
    parser.add_argument("--write", nargs="?", const=DATA)
    arguments = parser.parse_args()
    lines = []

    def say(**line):
        lines.append(line)
        print(json.dumps(line), flush=True)

    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "")
    with tempfile.TemporaryDirectory() as folder:
        run("samples", "write", "bracket", "--refinement", str(arguments.cells), "--out", folder, folder=folder)
        k, m, s = (sp.csr_matrix(scipy.io.mmread(os.path.join(folder, f"bracket{ending}.mtx"))) for ending in ("", ".mass", ".stress.fillet"))
        with open(os.path.join(folder, "bracket.json")) as file:
            description = json.load(file)
        points = np.array(description["points"])
        sets = description["point_sets"]
        rows = [average_rows(points, sets[of["name"]], np.array(of["position"]), k.shape[0]) for of in description["component"]["interfaces"]]
        say(kind="conditions", command="python3 tests/benches/stress.py " + " ".join(sys.argv[1:]), commit=git, machine={"cpu": cpu, "cores": os.cpu_count()},
            versions={"numpy": np.__version__, "scipy": scipy.__version__}, dofs=k.shape[0], places=s.shape[0] // 6)
        exact = {hertz: whole_stress(k, m, s, *rows, 2 * np.pi * hertz) for hertz in HERTZ}
        for modes in MODES:
            run("reduce", "bracket.mtx", "--modes", str(modes), "--force", "-q", folder=folder)
            told = run("reduce", "inspect", "bracket.dcb.h5", folder=folder)
            bound = next((line for line in told.splitlines() if line.startswith("stress ")), "")
            with h5py.File(os.path.join(folder, "bracket.dcb.h5")) as file:
                for hertz in HERTZ:
                    reference = exact[hertz]
                    errors = {}
                    for name, attachments in (("with", True), ("without", False)):
                        if modes or attachments:
                            found = reduced_stress(file, 2 * np.pi * hertz, attachments)
                            errors[name] = float(np.abs(found - reference).max() / np.abs(reference).max())
                    say(kind="error", modes=len(file["modes/eigenvalues"]), hertz=hertz, **errors)
            say(kind="bound", modes=modes, told=bound.strip())
    if arguments.write:
        with open(arguments.write, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
