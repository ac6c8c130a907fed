"""One shift or several for many modes: SLEPc's Krylov-Schur on MUMPS, all else equal, and `reduce` beside them.

    /usr/bin/python3 tests/benches/spectrum_slicing.py FOLDER [MODES]      FOLDER as peers/components.py makes it

Prints a line per way. An interval solve (`EPS` with `ALL`) factorizes K - s M at shifts it chooses and counts eigenvalues by the inertias; its
interval is given the exact ends, which a user would not know. Needs Debian's python3-slepc4py-real; `reduce` is taken from target/release.
"""
import json
import os
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "peers"))

import numpy as np  # noqa: E402
from slepc_modes import PETSc, SLEPc, load, nearest, shift_invert  # noqa: E402

# Inertias need MUMPS' own root node in sequence and zero pivots detected.
for name, value in (("mat_mumps_icntl_13", 1), ("mat_mumps_icntl_24", 1), ("mat_mumps_cntl_3", 1e-12)):
    PETSc.Options().setValue(name, value)

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def timed(name, solver):
    start = time.perf_counter()
    solver.solve()
    seconds = time.perf_counter() - start
    pairs = solver.getConverged()
    print(f"{name:32} {seconds:.2f} s, {pairs} pairs", flush=True)
    return np.sort([solver.getEigenvalue(i).real for i in range(pairs)])


def main(folder, modes):
    stiffness, mass = (load(os.path.join(folder, name + ".npz")) for name in ("stiffness", "mass"))
    with open(os.path.join(folder, "meta.json")) as file:
        shift = json.load(file)["shift"]
    values = timed("SLEPc, one shift", nearest(stiffness, mass, shift, 6 + modes + 1))
    sliced = shift_invert(stiffness, mass, 0.5 * values[6])
    sliced.setWhichEigenpairs(SLEPc.EPS.Which.ALL)
    sliced.setInterval(0.5 * values[6], 0.5 * (values[5 + modes] + values[6 + modes]))
    sliced.setKrylovSchurDetectZeros(True)
    found = timed("SLEPc, spectrum slicing", sliced)
    count = min(len(found), modes)
    print(f"largest difference {np.max(np.abs(found[:count] / values[6 : 6 + count] - 1)):.0e}")
    with tempfile.TemporaryDirectory() as out:
        timings = os.path.join(out, "timings.json")
        part = os.path.join(folder, "part.mtx")
        reduce = os.path.join(ROOT, "target", "release", "reduce")
        command = [reduce, part, "--modes", str(modes), "-o", os.path.join(out, "part.dcb.h5"), "-q", "--timings", timings]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        with open(timings) as file:
            stages = {stage["stage"]: stage["seconds"] for stage in json.load(file)["stages"]}
    print(f"{'reduce: order, factor and modes':32} {sum(stages[name] for name in ('order', 'factor', 'modes')):.2f} s")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 300)
