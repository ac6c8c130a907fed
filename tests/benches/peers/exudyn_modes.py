"""Exudyn's own eigenmodes of the same matrices: `FEMinterface.ComputeEigenmodes` alone is timed, without reading.

    python3 exudyn_modes.py FOLDER MODES OUT.npz

FOLDER as components.py makes it. One JSON line is printed. OUT gets the eigenvalues and modes, for the check.
"""
import json
import os
import resource
import sys
import time

import exudyn
import numpy as np
import scipy.sparse as sp
from exudyn.FEM import FEMinterface


def main(folder, count, out):
    part = FEMinterface()
    part.nodes = {"Position": np.load(os.path.join(folder, "geometry.npz"))["points"]}
    part.stiffnessMatrix, part.massMatrix = (sp.load_npz(os.path.join(folder, name + ".npz")) for name in ("stiffness", "mass"))
    start, processor = time.perf_counter(), time.process_time()
    part.ComputeEigenmodes(count, excludeRigidBodyModes=6, useSparseSolver=True)
    wall, processor = time.perf_counter() - start, time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    np.savez(out, **{"modes/eigenvalues": np.asarray(part.eigenValues), "modes/shapes": part.modeBasis["matrix"].T})
    print(json.dumps(dict(
        wall=wall, stages=dict(modes_with_factor=wall), processor=dict(total=processor), statistics={}, peak_mb=peak,
        versions=dict(exudyn=exudyn.__version__, numpy=np.__version__),
    )))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
