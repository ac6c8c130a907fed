"""pyNastran and pyyeti read what `reduce export --to nastran` wrote, in both dialects, and find the numbers of the npz export.

    python3 export_nastran.py PART.npz DMIG.bdf OP4.bdf      numpy<2 pyNastran pyyeti; OP4.op4 is beside OP4.bdf

Exit status 1 where a limit is broken.
"""
import os
import sys

import numpy as np
from pyNastran.bdf.bdf import BDF
from pyNastran.op4.op4 import OP4
from pyyeti.nastran import bulk, op4

DMIG, LOSSLESS = 1e-11, 0.0


def far(a, b):
    return float(np.abs(a - b).max() / np.abs(b).max())


def model_of(path):
    model = BDF(debug=None)
    model.read_bdf(path, punch=True, xref=False)
    return model


def dense(model, name, places):
    """A DMIG of pyNastran over the rows of the npz export: both triangles."""
    of = model.dmigs[name]
    found, rows, columns = of.get_matrix(is_sparse=False, apply_symmetry=True)
    out = np.zeros((len(places), len(places)))
    place = {p: i for i, p in enumerate(places)}
    for i, row in rows.items():
        for j, column in columns.items():
            out[place[row], place[column]] = found[i, j]
    return out


def main():
    reference = np.load(sys.argv[1])
    n, n_b = len(reference["K"]), len(reference["boundary"])
    frames = n_b // 6
    places = [(1 + i // 6, 1 + i % 6) for i in range(n_b)] + [(frames + 1 + i, 0) for i in range(n - n_b)]
    broken = False
    for path in sys.argv[2:4]:
        model = model_of(path)
        at = np.array([model.nodes[i + 1].xyz for i in range(frames)])
        off = far(at, reference["positions"])
        broken |= not off <= DMIG
        print(f"pyNastran reads {path}: {len(model.nodes)} GRID off by {off:.1e}, {len(model.spoints)} SPOINT of {n - n_b}, cards {sorted(model.card_count)}")
        broken |= len(model.spoints) != n - n_b
    model = model_of(sys.argv[2])
    for dmig, name in (("KAAX", "K"), ("MAAX", "M")):
        off = far(dense(model, dmig, places), reference[name])
        broken |= not off <= DMIG
        print(f"pyNastran: DMIG {dmig} off by {off:.1e} (allowed {DMIG:.0e})")
    of = bulk.rddmig(sys.argv[2])
    for dmig, name in (("kaax", "K"), ("maax", "M")):
        frame = of[dmig]
        off = far(frame.values, reference[name])
        broken |= not off <= DMIG
        print(f"pyyeti: DMIG {dmig} {frame.shape} off by {off:.1e} (allowed {DMIG:.0e})")
    matrices = op4.load(os.path.splitext(sys.argv[3])[0] + ".op4", into="dct")
    for matrix, name in (("kxx", "K"), ("mxx", "M")):
        found = matrices[matrix][0]
        off = far(found, reference[name])
        broken |= not off <= LOSSLESS
        print(f"pyyeti: OUTPUT4 {matrix} {found.shape} off by {off:.1e} (allowed {LOSSLESS:.0e})")
    matrices = OP4(debug=False).read_op4(os.path.splitext(sys.argv[3])[0] + ".op4")
    for matrix, name in (("KXX", "K"), ("MXX", "M")):
        found = matrices[matrix].data
        off = far(found, reference[name])
        broken |= not off <= LOSSLESS
        print(f"pyNastran: OUTPUT4 {matrix} {found.shape} off by {off:.1e} (allowed {LOSSLESS:.0e})")
    raise SystemExit(int(broken))


if __name__ == "__main__":
    main()
