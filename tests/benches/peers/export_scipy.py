"""SciPy reads what `reduce export --to simscape` and `--to npz` wrote: both hold the same, and the identities of a primal form.

    python3 export_scipy.py PART.mat PART.npz [PART.mtx PART.mass.mtx PART.dcb.h5]      numpy scipy (h5py)

With the finite elements' matrices (nodes in the order of the mesh, x, y, z each; first interface the mean of a node set): the part clamped at its first
interface against the same condition there. Exit status 1 where a limit is broken.
"""
import sys

import h5py
import numpy as np
import scipy.io
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as sla


def clamped_finite_elements(stiffness, mass, superelement, wanted):
    """Squares of the finite elements whose first frame, the least-squares mean of a node set, is at rest."""
    K, M = (sp.csc_matrix(scipy.io.mmread(path)) for path in (stiffness, mass))
    with h5py.File(superelement) as f:
        place = f["interfaces/positions"][0] + f["frame/origin"][:]
        points = f["mesh/points"][:]
        sets = [group[:] for group in f["mesh/point_sets"].values()]
    nodes = min(sets, key=lambda nodes: np.linalg.norm(points[nodes].mean(axis=0) - place))
    skew = lambda v: np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    G = np.zeros((K.shape[0], 6))                                                # rigid motions of the set; the frame is (GᵀG)⁻¹ Gᵀ u
    for node in nodes:
        G[3 * node : 3 * node + 3] = np.hstack([np.eye(3), -skew(points[node] - place)])
    Z = la.null_space(G.T)
    return la.eigh(Z.T @ (K @ Z), Z.T @ (M @ Z), subset_by_index=[0, wanted - 1], eigvals_only=True)


def main():
    m, z = scipy.io.loadmat(sys.argv[1]), np.load(sys.argv[2], allow_pickle=False)
    print("SciPy reads", sorted(k for k in m if not k.startswith("__")), "and NumPy", sorted(z.files))
    print("names", [str(n[0][0]) for n in m["names"]], "source", m["source"][0])
    broken = not all((m[k] == z[k]).all() for k in ("K", "M")) or not (m["origins"] == z["positions"]).all()
    R = np.zeros((len(z["K"]), 6)); R[: len(z["rigid"])] = z["rigid"]
    w2 = la.eigh(z["K"], z["M"], eigvals_only=True)
    print(f"K R {np.abs(z['K'] @ R).max() / np.abs(z['K']).max():.0e}; rigid squares below {np.abs(w2[:6]).max() / w2[6]:.0e} of the first elastic one")
    if len(sys.argv) > 5:
        ours = la.eigh(z["K"][6:, 6:], z["M"][6:, 6:], eigvals_only=True)[:7]
        whole = clamped_finite_elements(*sys.argv[3:6], 7)
        off = ours / whole - 1
        print("clamped at the first frame, against the finite elements:", " ".join(f"{v:.1e}" for v in off))
        broken |= not (np.abs(off) < 1e-4).all()
    raise SystemExit(int(broken))


if __name__ == "__main__":
    main()
