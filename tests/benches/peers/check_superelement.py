"""Checks a reduction from its file alone against the matrices it was made of: NumPy and SciPy, none of this project's code.

    python3 check_superelement.py FOLDER RESULT          FOLDER as components.py makes it, RESULT an .h5 or (modes alone) an .npz

One JSON line. With K, M the matrices, L_b rebuilt from part.json, Phi the modes, R the geometric rigid motions, X the attachment columns
and P' = I - M [R Phi] [R Phi]^T:

    mode_residual            largest |K phi - w2 M phi| / |K phi|
    orthonormality           largest entry of Phi^T M Phi - I
    rigid_orthogonality      largest entry of R^T M Phi
    attachment_residual      largest |K x - P' l| / |P' l|, l the column of L_b^T
    attachment_orthogonality largest entry of [R Phi]^T M X, relative to the column's norm in M
    flexibility_difference   L_b X against F_res, entry by entry, relative to the root of the product of the diagonal entries of its row
                             and its column (units differ, so the largest entry would hide the others); flexibility_asymmetry: F_res - F_res^T
    mass_difference          X^T M X against M_res, in the same way
    inertia_difference       mass, centre (of the part's radius of gyration), tensor
    coupling_difference      I1 of all columns, L3 and I2 between a sample of SAMPLE columns, of the product of the columns' norms in M

Whether a run counts, and which modes it missed, is judged from this in `judgement.py`.
"""
import json
import os
import sys

import numpy as np
import scipy.sparse as sp

SAMPLE, COLUMNS_AT_ONCE = 16, 16


class Result:
    """Datasets of a result by their names in a superelement, from HDF5 or NumPy's format."""

    def __init__(self, path):
        if path.endswith(".npz"):
            self.datasets = np.load(path)
        else:
            import h5py

            self.datasets = h5py.File(path, "r")

    def __contains__(self, name):
        return name in self.datasets

    def __getitem__(self, name):
        return np.asarray(self.datasets[name][()])

    def iterations(self):
        """Block steps of Lanczos and iterations of the attachments, where the file tells."""
        if "provenance" not in self.datasets:
            return None
        return json.loads(self.datasets["provenance"].attrs.get("quality", "{}")).get("iterations")


def interface_rows(description):
    """L_b, row by row as in the component file, sparse."""
    points = np.array(description["points"])
    rows, columns, entries, count = [], [], [], 0
    for interface in description["component"]["interfaces"]:
        nodes = np.array(description["point_sets"][interface["point_set"]])
        dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        if interface["kind"] == "nodes":
            block = np.eye(len(dofs))
        else:
            # The rigid motion nearest to the nodes' displacements in the least-squares sense is the pseudoinverse times them.
            arms = points[nodes] - points[nodes].mean(axis=0)
            motions = np.zeros((len(dofs), 6))
            for axis in range(3):
                motions[axis::3, axis] = 1
                motions[:, 3 + axis] = np.cross(np.eye(3)[axis], arms).ravel()
            block = np.linalg.pinv(motions)
        index = np.nonzero(block)
        rows.append(index[0] + count)
        columns.append(dofs[index[1]])
        entries.append(block[index])
        count += len(block)
    flat = [np.concatenate(part) for part in (entries, rows, columns)]
    return sp.csr_matrix((flat[0], (flat[1], flat[2])), shape=(count, 3 * len(points))), points


def rigid_motions(points, mass):
    """Geometric rigid motions, orthonormal in M."""
    size = np.ptp(points, axis=0).max()
    arms = (points - points.mean(axis=0)) / size
    motions = np.zeros((3 * len(points), 6))
    for axis in range(3):
        motions[axis::3, axis] = 1
        motions[:, 3 + axis] = np.cross(np.eye(3)[axis], arms).ravel()
    for _ in range(2):  # once more, against rounding
        values, vectors = np.linalg.eigh(motions.T @ (mass @ motions))
        motions = motions @ (vectors / np.sqrt(values))
    return motions


def blocks(count):
    return (slice(start, min(start + COLUMNS_AT_ONCE, count)) for start in range(0, count, COLUMNS_AT_ONCE))


def check_modes(stiffness, mass, rigid, values, shapes):
    """shapes: one mode a row."""
    count, defects = len(values), []
    gram, leak = np.empty((count, count)), 0.0
    for part in blocks(count):
        columns = np.ascontiguousarray(shapes[part].T)
        forces, weighted = stiffness @ columns, mass @ columns
        defects += (np.linalg.norm(forces - weighted * values[part], axis=0) / np.linalg.norm(forces, axis=0)).tolist()
        gram[:, part] = shapes @ weighted
        leak = max(leak, np.abs(rigid.T @ weighted).max())
    return dict(
        mode_residual=max(defects), orthonormality=float(np.abs(gram - np.eye(count)).max()), rigid_orthogonality=float(leak),
        mode_residuals=[float(f"{defect:.2e}") for defect in defects],
    )


def check_attachments(stiffness, mass, rows, kept, columns, flexibility, residual_mass):
    """kept: columns; columns: one attachment a row."""
    count = len(columns)
    weighted_kept = mass @ kept
    found_flexibility, found_mass = np.empty((count, count)), np.empty((count, count))
    defects, inner = [], np.empty((kept.shape[1], count))
    for part in blocks(count):
        block = np.ascontiguousarray(columns[part].T)
        forces = rows[part].T.toarray()
        forces -= weighted_kept @ (kept.T @ forces)
        defects += (np.linalg.norm(stiffness @ block - forces, axis=0) / np.linalg.norm(forces, axis=0)).tolist()
        weighted = mass @ block
        inner[:, part] = kept.T @ weighted
        found_flexibility[:, part] = rows @ block
        found_mass[:, part] = columns @ weighted
    norms = np.sqrt(np.diag(found_mass))
    sizes = np.sqrt(np.abs(np.diag(found_flexibility)))
    scale = sizes[:, None] * sizes  # rows differ in unit
    return dict(
        attachment_residual=max(defects), attachment_orthogonality=float((np.abs(inner) / norms).max()),
        flexibility_difference=float((np.abs(found_flexibility - flexibility) / scale).max()),
        flexibility_asymmetry=float((np.abs(flexibility - flexibility.T) / scale).max()),
        mass_difference=float((np.abs(found_mass - residual_mass) / (norms[:, None] * norms)).max()),
        attachments=count,
    )


def rigid_body(mass, points):
    """Mass, centre and tensor about it, from unit translations."""
    units = np.zeros((3 * len(points), 3))
    for axis in range(3):
        units[axis::3, axis] = 1
    weighted = mass @ units
    total = np.trace(units.T @ weighted) / 3
    centre = (points.ravel() @ weighted) / total
    arms = (points - centre).ravel()
    spread = np.zeros((3 * len(points), 3))
    for axis in range(3):  # unit rotations
        spread[:, axis] = np.cross(np.eye(3)[axis], arms.reshape(-1, 3)).ravel()
    return total, centre, spread.T @ (mass @ spread)


def check_inertia(mass, points, basis, result):
    """basis: one vector a row, as in the file's I1, L3 and I2."""
    total, centre, tensor = rigid_body(mass, points)
    gyration = np.sqrt(np.trace(tensor) / 2 / total)
    differences = [
        abs(result["inertia/mass"] / total - 1), np.abs(result["frame/origin"] - centre).max() / gyration,
        np.abs(result["inertia/tensor"] - tensor).max() / np.abs(tensor).max(),
    ]
    arms, count = points - centre, len(basis)
    picked = np.unique(np.linspace(0, count - 1, SAMPLE).astype(int))
    weighted = np.ascontiguousarray((mass @ basis[picked].T).T).reshape(len(picked), -1, 3)
    sample = basis[picked].reshape(len(picked), -1, 3)
    second = np.einsum("kia,lib->klab", sample, weighted, optimize=True)  # of density psi_k,a psi_l,b
    norms = np.sqrt(np.einsum("kkaa->k", second))
    expected_coupling = np.stack([second[:, :, (a + 1) % 3, (a + 2) % 3] - second[:, :, (a + 2) % 3, (a + 1) % 3] for a in range(3)])
    traces = np.einsum("klaa->kl", second)
    expected_quadratic = traces[:, :, None, None] * np.eye(3) - (second + second.transpose(0, 1, 3, 2)) / 2
    coupling = result["inertia/L3"][:, picked[:, None], picked]
    quadratic = result["inertia/I2"][picked[:, None], picked]
    products = norms[:, None] * norms
    worst = [
        (np.abs(coupling - expected_coupling) / products).max(),
        (np.abs(quadratic - expected_quadratic) / products[:, :, None, None]).max(),
    ]
    linear = result["inertia/I1"]
    for part in blocks(count):
        columns = mass @ np.ascontiguousarray(basis[part].T)
        size = np.sqrt(np.einsum("ik,ki->k", columns, basis[part]))
        first = np.einsum("ia,ibk->kab", arms, columns.reshape(-1, 3, columns.shape[1]), optimize=True)
        traces = np.einsum("kaa->k", first)[:, None, None]
        expected = 2 * traces * np.eye(3) - first - first.transpose(0, 2, 1)
        worst.append((np.abs(linear[part] - expected) / (size * np.sqrt(total) * gyration)[:, None, None]).max())
    return dict(
        inertia_difference=float(max(differences)), coupling_difference=float(max(worst)),
        coupling_sample=f"L3 and I2: {len(picked)} of {count} columns",
    )


def check(folder, path):
    stiffness, mass = (sp.load_npz(os.path.join(folder, name + ".npz")) for name in ("stiffness", "mass"))
    with open(os.path.join(folder, "part.json")) as file:
        rows, points = interface_rows(json.load(file))
    result = Result(path)
    values, shapes = result["modes/eigenvalues"], result["modes/shapes"]
    rigid = rigid_motions(points, mass)
    found = check_modes(stiffness, mass, rigid, values, shapes)
    if "residual/shapes" in result:
        columns = result["residual/shapes"]
        kept = np.hstack([rigid, shapes.T])
        found |= check_attachments(stiffness, mass, rows, kept, columns, result["residual/flexibility"], result["residual/mass"])
        del stiffness, kept
        found |= check_inertia(mass, points, np.vstack([shapes, columns]), result)
    return dict(eigenvalues=values.tolist(), iterations=result.iterations(), check=found)


if __name__ == "__main__":
    print(json.dumps(check(sys.argv[1], sys.argv[2])))
