"""Small matrices in every layout of OUTPUT4 and in DMIG, written by pyyeti and pyNastran, and the same as Matrix Market for comparison.

  python nastran_variants.py        pyyeti 1.4.7, pyNastran 1.4.1, numpy < 2, scipy
"""
import os
import numpy as np
import scipy.io
import scipy.sparse as sp
from pyNastran.bdf.bdf import BDF, read_bdf
from pyyeti.nastran import op4

OUT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "nastran")
rng = np.random.default_rng(16)


def symmetric(n, density, empty=()):
    """Values over many orders of magnitude, the diagonal full; rows and columns of `empty` have none."""
    lower = sp.tril(sp.random(n, n, density, random_state=rng, data_rvs=lambda k: rng.standard_normal(k) * 10.0 ** rng.integers(-30, 30, k)))
    full = (lower + sp.tril(lower, -1).T).tolil()
    full.setdiag(rng.standard_normal(n))
    for i in empty:
        full[i, :] = 0
        full[:, i] = 0
    full = full.tocsc()
    full.eliminate_zeros()
    return full


K = symmetric(30, 0.2, empty=(0, 7, 8, 29)).tolil()
K[3, 3] = 2.5e-310                      # subnormal
K[4, 4], K[5, 5] = 1.7e308, -1e-300
K = K.tocsc()
WIDE = sp.coo_matrix(([1.5, -2.5, -2.5, 3.5, 1e-9], ([0, 0, 69_999, 69_999, 65_536], [0, 69_999, 0, 69_999, 65_536])), shape=(70_000, 70_000)).tocsc()
R = sp.random(30, 11, 0.3, random_state=rng).tocsc()
C = sp.random(9, 9, 0.3, random_state=rng).tocsc() * (1 + 2j)

scipy.io.mmwrite(os.path.join(OUT, "variants.mtx"), K, symmetry="symmetric", precision=17)
scipy.io.mmwrite(os.path.join(OUT, "variants_wide.mtx"), WIDE, symmetry="symmetric", precision=17)
names, matrices = ["first", "r", "c", "k"], [K * 0.5, R, C, K]
for layout in ("dense", "bigmat", "nonbigmat"):
    for endian, suffix in (("<", "le"), (">", "be")):
        op4.write(os.path.join(OUT, f"variants_{layout}_{suffix}.op4"), names, matrices, sparse=layout, binary=True, endian=endian)
    tame = [sp.csc_matrix((np.where(np.abs(m.data) < 1e-99, 0.25, np.where(np.abs(m.data) > 1e99, -0.75, m.data)), m.indices, m.indptr), m.shape) for m in matrices]
    op4.write(os.path.join(OUT, f"variants_{layout}_ascii.op4"), names, tame, sparse=layout, binary=False, digits=16)
    op4.write(os.path.join(OUT, f"variants_{layout}_ascii_9.op4"), names, tame, sparse=layout, binary=False, digits=8)
scipy.io.mmwrite(os.path.join(OUT, "variants_tame.mtx"), tame[3], symmetry="symmetric", precision=17)
op4.write(os.path.join(OUT, "variants_wide.op4"), ["wide"], [WIDE], sparse="nonbigmat", binary=True, endian="<")
op4.write(os.path.join(OUT, "variants_wide_ascii.op4"), ["wide"], [WIDE], sparse="nonbigmat", binary=False, digits=16)

# DMIG: rows of grids with six components each (labels 5, 12, 1000000, 99999999), then scalar points, upper triangle, columns from the last to the first.
labels = [(g, c) for g in (5, 12, 1_000_000, 99_999_999) for c in range(1, 7)] + [(g, 0) for g in (7, 900, 901, 902, 903, 2_147_483)]
tame = tame[3]
upper = sp.triu(tame).tocoo()
order = np.lexsort((upper.row, -upper.col))
for name, size, double, tin in (("variants_double.pch", 16, True, 2), ("variants_large.pch", 16, False, 1), ("variants_small.pch", 8, False, 1)):
    model = BDF(debug=None)
    model.add_dmig("KAAX", 6, tin, 0, 0, None, [labels[j] for j in upper.col[order]], [labels[i] for i in upper.row[order]], upper.data[order].tolist())
    square = tame.tocoo()
    model.add_dmig("B2GG", 1, tin, 0, 0, None, [labels[j] for j in square.col], [labels[i] for i in square.row], square.data.tolist())
    with open(os.path.join(OUT, name), "w") as f:
        for matrix in ("KAAX", "B2GG"):
            f.write(model.dmig[matrix].write_card(size=size, is_double=double))
with open(os.path.join(OUT, "variants_labels.txt"), "w") as f:
    f.writelines(f"{g} {c}\n" for g, c in labels)
