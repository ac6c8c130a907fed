"""Eigenpairs alone with SLEPc: Krylov-Schur, shift-invert on MUMPS' Cholesky (METIS), in one process or several.

    [mpiexec -n 2] /usr/bin/python3 slepc_modes.py FOLDER MODES OUT.npz

Needs Debian's python3-slepc4py-real and the Python it was built for; FOLDER as components.py makes it. Reading isn't timed. One JSON line
is printed; memory is the sum of the processes'. OUT gets the elastic eigenvalues and modes, for the check.
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
    first, end = (size * (PETSc.COMM_WORLD.rank + i) // PETSc.COMM_WORLD.size for i in (0, 1))  # this process's rows
    starts = arrays["indptr"][first : end + 1]
    entries = slice(starts[0], starts[-1])
    rows = (starts - starts[0]).astype(PETSc.IntType), arrays["indices"][entries].astype(PETSc.IntType), arrays["data"][entries]
    matrix = PETSc.Mat().createAIJ(size=((end - first, size), (end - first, size)), csr=rows)
    matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return matrix


def total(number):
    """The sum over all processes."""
    vector = PETSc.Vec().createMPI((1, PETSc.DECIDE))
    vector.set(number)
    return vector.sum()


def shift_invert(stiffness, mass, shift):
    """Krylov-Schur on MUMPS' factor of K - shift M, without saying which pairs are wanted."""
    solver = SLEPc.EPS().create()
    solver.setOperators(stiffness, mass)
    solver.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    solver.setTolerances(1e-10)
    transformation = solver.getST()
    transformation.setType("sinvert")
    transformation.setShift(shift)
    linear = transformation.getKSP()
    linear.setType("preonly")
    linear.getPC().setType("cholesky")
    linear.getPC().setFactorSolverType("mumps")
    return solver


def nearest(stiffness, mass, shift, count):
    """The same for the `count` pairs nearest to the shift."""
    solver = shift_invert(stiffness, mass, shift)
    solver.setDimensions(count)
    solver.setTarget(shift)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    return solver


def main(folder, count, out):
    stiffness, mass = (load(os.path.join(folder, name + ".npz")) for name in ("stiffness", "mass"))
    with open(os.path.join(folder, "meta.json")) as file:
        shift = json.load(file)["shift"]
    PETSc.COMM_WORLD.barrier()
    start, processor = time.perf_counter(), time.process_time()
    solver = nearest(stiffness, mass, shift, 6 + count)
    solver.setUp()
    ready = time.perf_counter()
    solver.solve()
    done = time.perf_counter()
    processor = time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    pairs = solver.getConverged()
    values = np.array([solver.getEigenvalue(i).real for i in range(pairs)])
    elastic = np.argsort(values)[6 : 6 + count]
    vector = stiffness.createVecRight()
    scatter, gathered = PETSc.Scatter.toZero(vector)
    shapes = []
    for index in elastic:
        solver.getEigenvector(index, vector)
        scatter.scatter(vector, gathered)
        shapes.append(gathered.getArray().copy())
    peak, processor = total(peak), total(processor)
    if PETSc.COMM_WORLD.rank:
        return
    np.savez(out, **{"modes/eigenvalues": values[elastic], "modes/shapes": np.array(shapes)})
    print(json.dumps(dict(
        wall=done - start, stages=dict(factor_with_order=ready - start, modes=done - ready), processor=dict(total=processor),
        statistics=dict(restarts=solver.getIterationNumber(), converged=pairs), peak_mb=peak,
        versions=dict(slepc=".".join(map(str, SLEPc.Sys.getVersion())), petsc=".".join(map(str, PETSc.Sys.getVersion()))),
    )))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
