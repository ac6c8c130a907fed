"""Eigenpairs alone with SLEPc: Krylov-Schur, shift-invert on MUMPS' Cholesky (METIS), one process.

    /usr/bin/python3 slepc_modes.py FOLDER MODES OUT.npz

Needs Debian's python3-slepc4py-real and the Python it was built for; FOLDER as components.py makes it. Reading isn't timed. One JSON line
is printed; `setup` is order and factor. OUT gets the elastic eigenvalues and modes, for the check.
"""
import glob
import json
import os
import resource
import sys
import time

for pattern in ("/usr/lib/petscdir/petsc*/*-real", "/usr/lib/slepcdir/slepc*/*-real"):
    sys.path[:0] = glob.glob(pattern + "/lib/python3/dist-packages")

import numpy as np  # noqa: E402
import slepc4py  # noqa: E402

slepc4py.init(["slepc", "-mat_mumps_icntl_7", "5"])
from petsc4py import PETSc  # noqa: E402
from slepc4py import SLEPc  # noqa: E402


def load(path):
    arrays = np.load(path)
    size = int(arrays["shape"][0])
    rows = arrays["indptr"].astype(PETSc.IntType), arrays["indices"].astype(PETSc.IntType), arrays["data"]
    matrix = PETSc.Mat().createAIJ(size=(size, size), csr=rows)
    matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return matrix


def main(folder, count, out):
    stiffness, mass = (load(os.path.join(folder, name + ".npz")) for name in ("stiffness", "mass"))
    with open(os.path.join(folder, "meta.json")) as file:
        shift = json.load(file)["shift"]
    start, processor = time.perf_counter(), time.process_time()
    solver = SLEPc.EPS().create()
    solver.setOperators(stiffness, mass)
    solver.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    solver.setDimensions(6 + count)
    solver.setTolerances(1e-10)
    solver.setTarget(shift)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    transformation = solver.getST()
    transformation.setType("sinvert")
    transformation.setShift(shift)
    linear = transformation.getKSP()
    linear.setType("preonly")
    linear.getPC().setType("cholesky")
    linear.getPC().setFactorSolverType("mumps")
    solver.setUp()
    ready = time.perf_counter()
    solver.solve()
    done = time.perf_counter()
    processor = time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    pairs = solver.getConverged()
    values = np.array([solver.getEigenvalue(i).real for i in range(pairs)])
    elastic = np.argsort(values)[6 : 6 + count]
    vector, shapes = stiffness.createVecRight(), np.empty((len(elastic), stiffness.size[0]))
    for row, index in zip(shapes, elastic):
        solver.getEigenvector(index, vector)
        row[:] = vector.getArray()
    np.savez(out, **{"modes/eigenvalues": values[elastic], "modes/shapes": shapes})
    print(json.dumps(dict(
        wall=done - start, stages=dict(factor_with_order=ready - start, modes=done - ready), processor=dict(total=processor),
        statistics=dict(restarts=solver.getIterationNumber(), converged=pairs), peak_mb=peak,
        versions=dict(slepc=".".join(map(str, SLEPc.Sys.getVersion())), petsc=".".join(map(str, PETSc.Sys.getVersion()))),
    )))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
