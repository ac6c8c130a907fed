"""One reduction with a direct solver and ARPACK, from Matrix Market files to an HDF5 file: the same job as `reduce`'s.

    python3 reduction.py FOLDER TOOL MODES OUT.h5          tools: see solvers.py; FOLDER as components.py makes it
    python3 reduction.py FOLDER TOOL --analysis            entries and flops of the factor alone

A = K - shift M (shift < 0, so A is positive definite) is factorized once. Lanczos (ARPACK through SciPy) finds 6 rigid and MODES elastic
modes; the attachment columns of all interface rows come by fixed-point refinement on the same factor, the kept modes projected out; F_res,
M_res and the invariants of inertia follow from the columns. The file has the datasets of a superelement that a check needs, contiguous, so
the same checks apply. One JSON line is printed: times since the start of this script's work (imports are apart), statistics.
"""
import time

STARTED = time.perf_counter()

import json  # noqa: E402
import os  # noqa: E402
import resource  # noqa: E402
import sys  # noqa: E402

import fast_matrix_market as fmm  # noqa: E402
import h5py  # noqa: E402
import numpy as np  # noqa: E402
import scipy.sparse as sp  # noqa: E402
from scipy.sparse.linalg import LinearOperator, eigsh  # noqa: E402

import solvers  # noqa: E402

COLUMNS_AT_ONCE = 64  # of the attachments: wide blocks are fast, narrower ones need less memory
THREADS = int(os.environ.get("OMP_NUM_THREADS", "1"))


class Laps:
    def __init__(self):
        self.stages, self.processor = {}, {}
        self.last = time.perf_counter(), time.process_time()

    def __call__(self, stage):
        now = time.perf_counter(), time.process_time()
        for spent, start, end in zip((self.stages, self.processor), self.last, now):
            spent[stage] = spent.get(stage, 0) + end - start
        self.last = now


def read(folder):
    stiffness, mass = (
        sp.csr_matrix(fmm.mmread(os.path.join(folder, name), parallelism=THREADS)) for name in ("part.mtx", "part.mass.mtx")
    )
    with open(os.path.join(folder, "meta.json")) as file:
        meta = json.load(file)
    return stiffness, mass, np.load(os.path.join(folder, "geometry.npz")), meta


def shifted(stiffness, mass, shift):
    matrix = (stiffness - shift * mass).tocsr()
    matrix.sort_indices()
    return matrix


def modes(solver, stiffness, mass, rigid, shift, count, statistics):
    """Elastic modes, orthogonal to the geometric rigid ones."""
    size = stiffness.shape[0]
    spent = [0, 0.0]

    def solve(vector):
        start = time.perf_counter()
        solution = solver.solve(np.ravel(vector))
        spent[0] += 1
        spent[1] += time.perf_counter() - start
        return solution

    start_vector = np.random.default_rng(0).standard_normal(size)
    values, shapes = eigsh(
        stiffness, k=6 + count, M=mass, sigma=shift, OPinv=LinearOperator((size, size), solve), v0=start_vector, tol=1e-10
    )
    statistics.update(lanczos_solves=spent[0], lanczos_solve_seconds=round(spent[1], 4))
    statistics.update(solve_columns=spent[0], solve_passes=spent[0])
    order = np.argsort(values)[6:]
    values, shapes = values[order], shapes[:, order]
    shapes -= rigid @ (rigid.T @ (mass @ shapes))
    return values, shapes


def attachments(solver, stiffness, mass, kept, forces, statistics, refinements=8, tolerance=1e-12):
    """Columns X with K X = (I - M Phi Phi^T) L_b^T and Phi^T M X = 0."""
    mass_kept = mass @ kept
    columns = np.empty(forces.shape, order="F")

    def solve(right):
        statistics["solve_columns"] += right.shape[1]
        statistics["solve_passes"] += 1
        return solver.solve(right)

    for start in range(0, forces.shape[1], COLUMNS_AT_ONCE):
        block = forces[:, start : start + COLUMNS_AT_ONCE]
        block = block.toarray() if sp.issparse(block) else block
        right = block - mass_kept @ (kept.T @ block)
        norms = np.linalg.norm(right, axis=0)
        solution = solve(right)
        before = np.inf
        for step in range(refinements):
            solution -= kept @ (mass_kept.T @ solution)
            residual = right - stiffness @ solution
            worst = float((np.linalg.norm(residual, axis=0) / norms).max())
            if worst < tolerance or (step > 1 and worst > 0.3 * before):
                break
            before = worst
            solution += solve(residual)
        columns[:, start : start + COLUMNS_AT_ONCE] = solution
    return columns


def invariants(mass, points, basis):
    """Mass, centre and tensor, and the couplings I1, L3 and I2 of a basis, about the centre of mass. The mass is the same in all directions."""
    nodal = mass[::3, ::3]
    total = nodal.sum()
    centre = (nodal @ points).sum(0) / total
    arms = points - centre
    moment = arms.T @ (nodal @ arms)
    directions = [np.ascontiguousarray(basis[axis::3]) for axis in range(3)]
    weighted = [nodal @ direction for direction in directions]
    count = basis.shape[1]
    first = np.empty((count, 3, 3))  # integral of density r_a psi_b
    for axis in range(3):
        first[:, :, axis] = (arms.T @ weighted[axis]).T
    second = np.empty((3, 3, count, count))  # of density psi_k,a psi_l,b
    for a in range(3):
        for b in range(a, 3):
            second[a, b] = directions[a].T @ weighted[b]
            second[b, a] = second[a, b].T
    trace = np.trace(second)
    coupling = np.array([second[1, 2] - second[2, 1], second[2, 0] - second[0, 2], second[0, 1] - second[1, 0]])
    quadratic = np.empty((count, count, 3, 3))
    for a in range(3):
        for b in range(3):
            quadratic[:, :, a, b] = (trace if a == b else 0) - (second[a, b] + second[b, a]) / 2
    eye = np.eye(3)
    linear = 2 * np.trace(first, axis1=1, axis2=2)[:, None, None] * eye - first - first.transpose(0, 2, 1)
    return {
        "frame/origin": centre, "inertia/mass": total, "inertia/tensor": np.trace(moment) * eye - moment, "inertia/I1": linear,
        "inertia/L3": coupling, "inertia/I2": quadratic,
    }


def main(folder, tool, count, out):
    solver = solvers.make(tool)  # loads its library: that is import time, too
    imports = time.perf_counter() - STARTED
    start = time.perf_counter()
    lap, statistics = Laps(), {}
    stiffness, mass, geometry, meta = read(folder)
    rigid, average, raw = geometry["rigid"], geometry["average"], geometry["raw_dofs"]
    lap("read")
    matrix = shifted(stiffness, mass, meta["shift"])
    lap("model")
    solver.analyze(matrix)
    del matrix
    lap("order")
    solver.factor()
    lap("factor")
    values, shapes = modes(solver, stiffness, mass, rigid, meta["shift"], count, statistics)
    lap("modes")
    size = stiffness.shape[0]
    picked = sp.csc_matrix((np.ones(len(raw)), (raw, np.arange(len(raw)))), shape=(size, len(raw)))
    forces = sp.hstack([sp.csc_matrix(average), picked], format="csc")
    columns = attachments(solver, stiffness, mass, np.hstack([rigid, shapes]), forces, statistics)
    flexibility = forces.T @ columns
    residual_mass = columns.T @ (mass @ columns)
    lap("attachments")
    inertia = invariants(mass, geometry["points"], np.hstack([shapes, columns]))
    lap("invariants")
    with h5py.File(out, "w") as file:
        file["modes/eigenvalues"], file["modes/shapes"] = values, shapes.T
        file["residual/shapes"], file["residual/flexibility"], file["residual/mass"] = columns.T, flexibility, residual_mass
        for name, value in inertia.items():
            file[name] = value
    lap("write")
    print(json.dumps(dict(
        wall=time.perf_counter() - start, imports=imports, stages=lap.stages, processor=lap.processor,
        statistics=statistics | solver.statistics, versions=solvers.versions(tool),
        peak_mb=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    )))


def analysis(folder, tool):
    """The factor's entries and flops, from matrices in NumPy's format."""
    stiffness, mass = (sp.load_npz(os.path.join(folder, name + ".npz")) for name in ("stiffness", "mass"))
    with open(os.path.join(folder, "meta.json")) as file:
        matrix = shifted(stiffness, mass, json.load(file)["shift"])
    solver = solvers.make(tool)
    solver.analyze(matrix)
    print(json.dumps(dict(**solver.statistics, entries=int(stiffness.nnz), versions=solvers.versions(tool))))


if __name__ == "__main__":
    if sys.argv[3:] == ["--analysis"]:
        analysis(*sys.argv[1:3])
    else:
        main(sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4])
