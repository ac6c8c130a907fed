"""Generated solid components: Gmsh mesh of tetrahedra (straight sides) -> free-free stiffness and mass, interfaces, input files of `reduce`.

    python3 components.py conrod-50k [block-150k ...] [--linear]

A name is a shape (`conrod`: slender, `block`: compact, `plate`: thin) and a number of dofs (`50k`, `1M`), met to a few percent. A
component's folder, in $PERF_DATA (default: perf-data in the temporary folder), gets

    part.mtx, part.mass.mtx, part.json    what `reduce` reads: two averaged bearings and 34 single nodes (12 + 102 rows)
    geometry.npz, meta.json               points, node sets, forces of the averaged rows, rigid modes, a shift
    stiffness.npz, mass.npz               the same matrices for tools that can't read Matrix Market

Dof = 3 node + direction, SI units, steel. The mesh is the same for the same Gmsh version (fixed seed, one thread). Needs gmsh, numpy, scipy
and fast_matrix_market.
"""
import argparse
import itertools
import json
import math
import os
import re
import tempfile

import numpy as np
import scipy.sparse as sp

DATA = os.environ.get("PERF_DATA", os.path.join(tempfile.gettempdir(), "perf-data"))
YOUNG, POISSON, DENSITY = 2.1e11, 0.3, 7850.0
RAW_NODES_PER_SET = 17
FIRST_SIZE = {"conrod": 2.1e-4, "block": 7.2e-4, "plate": 1.9e-4}
THICKNESS = {"conrod": 0.02, "block": 0.08, "plate": 0.005}
MIDSIDES = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]  # Gmsh's order of a quadratic tetrahedron


def path(name, *parts):
    return os.path.join(DATA, name, *parts)


def dofs_of(name):
    """'conrod-50k' -> ('conrod', 50000)."""
    shape, number, unit = re.fullmatch(r"(\w+)-(\d+)([kM])(?:-linear)?", name).groups()
    return shape, int(number) * {"k": 1000, "M": 1_000_000}[unit]


def connecting_rod(occ):
    thickness = 0.020
    big = occ.addCylinder(0, 0, 0, 0, 0, thickness, 0.032)
    small = occ.addCylinder(0.18, 0, 0, 0, 0, thickness, 0.018)
    shank = occ.addBox(0, -0.010, 0.004, 0.18, 0.020, 0.012)
    solid, _ = occ.fuse([(3, big)], [(3, small), (3, shank)])
    bores = [occ.addCylinder(0, 0, 0, 0, 0, thickness, 0.022), occ.addCylinder(0.18, 0, 0, 0, 0, thickness, 0.011)]
    occ.cut(solid, [(3, bore) for bore in bores])
    return 0.23, [
        lambda x: np.abs(np.hypot(x[:, 0], x[:, 1]) - 0.022) < 2e-4,
        lambda x: np.abs(np.hypot(x[:, 0] - 0.18, x[:, 1]) - 0.011) < 2e-4,
    ]


def block(occ):
    occ.addBox(0, 0, 0, 0.1, 0.09, 0.08)
    return 0.1, [lambda x: x[:, 0] < 1e-9, lambda x: x[:, 0] > 0.1 - 1e-9]


def plate(occ):
    occ.addBox(0, 0, 0, 0.4, 0.1, 0.005)
    centres = (0.06, 0.34)
    holes = [(3, occ.addCylinder(centre, 0.05, 0, 0, 0, 0.005, 0.02)) for centre in centres]
    occ.cut([(3, 1)], holes)
    return 0.4, [lambda x, c=centre: np.abs(np.hypot(x[:, 0] - c, x[:, 1] - 0.05) - 0.02) < 1e-4 for centre in centres]


SHAPES = {"conrod": connecting_rod, "block": block, "plate": plate}


def mesh(shape, size, quadratic):
    """Points, tetrahedra, whether a point is in each interface, length of the part."""
    import gmsh

    gmsh.initialize(interruptible=False)
    for option, value in (
        ("General.Terminal", 0), ("General.NumThreads", 1), ("Mesh.RandomSeed", 1),
        ("Mesh.MeshSizeMin", size), ("Mesh.MeshSizeMax", size), ("Mesh.SecondOrderLinear", 1),
    ):
        gmsh.option.setNumber(option, value)
    length, sets = SHAPES[shape](gmsh.model.occ)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.generate(3)
    if quadratic:
        gmsh.model.mesh.setOrder(2)
    tags, points, _ = gmsh.model.mesh.getNodes()
    types, _, cells = gmsh.model.mesh.getElements(3)
    gmsh.finalize()
    points = points.reshape(-1, 3)
    row_of_tag = np.zeros(int(tags.max()) + 1, np.int64)
    row_of_tag[tags.astype(np.int64)] = np.arange(len(tags))
    cells = row_of_tag[cells[0].astype(np.int64)].reshape(-1, {4: 4, 11: 10}[types[0]])
    used = np.unique(cells)
    renumbered = np.full(len(points), -1, np.int64)
    renumbered[used] = np.arange(len(used))
    return points[used], renumbered[cells], sets, length


def reference_integrals(quadratic):
    """Exact means over a tetrahedron in barycentric coordinates L: of dN_i/dL_k dN_j/dL_l as [k, l, i, j], and of N_i N_j.

    A polynomial is a dictionary from exponents to coefficients."""

    def monomial(*factors):
        return tuple(factors.count(corner) for corner in range(4))

    def product(one, other):
        result = {}
        for (a, x), (b, y) in itertools.product(one.items(), other.items()):
            exponents = tuple(i + j for i, j in zip(a, b))
            result[exponents] = result.get(exponents, 0) + x * y
        return result

    def mean(polynomial):
        return sum(
            6 * x * math.prod(math.factorial(e) for e in exponents) / math.factorial(sum(exponents) + 3)
            for exponents, x in polynomial.items()
        )

    def derivative(polynomial, k):
        return {
            exponents[:k] + (exponents[k] - 1,) + exponents[k + 1 :]: x * exponents[k]
            for exponents, x in polynomial.items()
            if exponents[k]
        }

    if quadratic:
        functions = [{monomial(i, i): 2.0, monomial(i): -1.0} for i in range(4)] + [{monomial(a, b): 4.0} for a, b in MIDSIDES]
    else:
        functions = [{monomial(i): 1.0} for i in range(4)]
    slopes = [[derivative(function, k) for function in functions] for k in range(4)]
    gradients = np.array([
        [[[mean(product(a, b)) for b in slopes[l]] for a in slopes[k]] for l in range(4)] for k in range(4)
    ])
    return gradients, np.array([[mean(product(a, b)) for b in functions] for a in functions])


def assemble(points, cells):
    """Exactly symmetric stiffness and mass (CSR), and the volumes of the elements."""
    gradients, masses = reference_integrals(cells.shape[1] == 10)
    nodes, corners = len(points), cells.shape[1]
    edges = np.stack([points[cells[:, i]] - points[cells[:, 0]] for i in (1, 2, 3)], axis=2)
    volumes = np.abs(np.linalg.det(edges) / 6)
    assert (volumes > 0).all()
    inverse = np.linalg.inv(edges)  # its rows are the gradients of L_1 to L_3
    slopes = np.concatenate([-inverse.sum(1, keepdims=True), inverse], axis=1)
    lame = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
    shear = YOUNG / 2 / (1 + POISSON)
    rows = np.repeat(cells, corners, axis=1).ravel().astype(np.int32)
    columns = np.tile(cells, (1, corners)).ravel().astype(np.int32)
    gradients = gradients.reshape(16, corners * corners)

    def slope_products(a, b):
        weights = slopes[:, :, a][:, :, None] * slopes[:, :, b][:, None, :] * volumes[:, None, None]
        return weights.reshape(-1, 16) @ gradients

    def summed(values):
        matrix = sp.coo_array((values.ravel(), (rows, columns)), shape=(nodes, nodes)).tocsr()
        matrix.sort_indices()
        return matrix

    laplacian = sum(slope_products(a, a) for a in range(3))
    data = pattern = None
    for a, b in itertools.product(range(3), range(3)):
        entries = lame * slope_products(a, b) + shear * slope_products(b, a) + (shear * laplacian if a == b else 0)
        part = summed(entries)
        if data is None:
            pattern, data = (part.indices, part.indptr), np.empty((part.nnz, 3, 3))
        data[:, a, b] = part.data
    del entries, part, laplacian
    stiffness = sp.bsr_array((data, *pattern), shape=(3 * nodes, 3 * nodes)).tocsr()
    mass = sp.kron(summed(DENSITY * volumes[:, None] * masses.ravel()[None, :]), sp.eye_array(3), format="csr")
    symmetric = []
    for matrix in (stiffness, mass):
        matrix = (matrix + matrix.T) * 0.5
        matrix.sort_indices()
        symmetric.append(sp.csr_matrix(matrix))
    return (*symmetric, volumes)


def rigid_motions(points, about):
    """Unit translations and unit rotations about a point, as six columns."""
    columns = np.zeros((3 * len(points), 6))
    for axis in range(3):
        columns[axis::3, axis] = 1
        columns[:, 3 + axis] = np.cross(np.eye(3)[axis], points - about).ravel()
    return columns


def rigid_modes(points, mass):
    """The six geometric rigid motions, mass-orthonormal."""
    motions = rigid_motions(points, points.mean(0))
    cholesky = np.linalg.cholesky(motions.T @ (mass @ motions))
    return np.linalg.solve(cholesky, motions.T).T.copy()


def average_forces(points, nodes):
    """Six columns of L_b^T of an averaged frame: the least-squares motion of the nodes about their centroid is these columns times u."""
    motions = rigid_motions(points[nodes], points[nodes].mean(0))
    columns = np.zeros((3 * len(points), 6))
    columns[(3 * nodes[:, None] + np.arange(3)).ravel()] = motions @ np.linalg.inv(motions.T @ motions)
    return columns


def generate(name):
    import fast_matrix_market as fmm

    shape, wanted = dofs_of(name)
    quadratic = not name.endswith("-linear")
    size = FIRST_SIZE[shape] ** (1 / 3) * (0.16 if quadratic else 0.08)
    for _ in range(6):
        points, cells, in_set, length = mesh(shape, size, quadratic)
        ratio = 3 * len(points) / wanted
        if 0.95 < ratio < 1.06:
            break
        size *= ratio ** (1 / 3) if ratio > 0.3 else ratio**0.4
    stiffness, mass, volumes = assemble(points, cells)
    sets = [np.flatnonzero(inside(points)) for inside in in_set]
    picked = [nodes[np.linspace(0, len(nodes) - 1, RAW_NODES_PER_SET).astype(int)] for nodes in sets]
    raw = np.unique(np.concatenate(picked))
    rigid = rigid_modes(points, mass)
    # Shift: a hundredth of the squared first bending frequency of a bar of this length and thickness. A user of a shift-invert
    # solver has to know such a number; the peers get it, `reduce` finds its own.
    bending = 22.4 / length**2 * math.sqrt(YOUNG / DENSITY) * THICKNESS[shape] / math.sqrt(12)
    meta = dict(
        name=name, shape=shape, quadratic=quadratic, size=size, nodes=len(points), cells=len(cells), dofs=3 * len(points),
        stiffness_entries=int(stiffness.nnz), mass_entries=int(mass.nnz), mass=float(DENSITY * volumes.sum()),
        shift=-((0.1 * bending) ** 2), interface_nodes=[len(nodes) for nodes in sets], raw_nodes=len(raw),
        rigid_residual=float(np.abs(stiffness @ rigid).max() / (np.abs(stiffness).max() * np.abs(rigid).max())),
    )
    os.makedirs(path(name), exist_ok=True)
    for matrix, stem, beside in ((stiffness, "part", "stiffness"), (mass, "part.mass", "mass")):
        fmm.mmwrite(path(name, stem + ".mtx"), matrix, symmetry="symmetric", precision=17)  # lower triangle
        sp.save_npz(path(name, beside + ".npz"), matrix, compressed=False)
    named = {f"set{i}": nodes.tolist() for i, nodes in enumerate(sets)}
    interfaces = [dict(name=key, point_set=key, kind="average") for key in named]
    interfaces.append(dict(name="raw", point_set="raw", kind="nodes"))
    component = dict(name=name, units=dict(length="m", mass="kg", time="s"), dofs=["ux", "uy", "uz"], interfaces=interfaces)
    with open(path(name, "part.json"), "w") as file:
        json.dump(dict(points=points.tolist(), cells=[], point_sets=named | dict(raw=raw.tolist()), component=component), file)
    np.savez(
        path(name, "geometry.npz"), points=points, cells=cells, rigid=rigid, set0=sets[0], set1=sets[1],
        raw_dofs=(3 * raw[:, None] + np.arange(3)).ravel(), average=np.hstack([average_forces(points, nodes) for nodes in sets]),
    )
    with open(path(name, "meta.json"), "w") as file:  # last: its presence says that the folder is complete
        json.dump(meta, file, indent=1)
    return meta


def is_there(name):
    return os.path.exists(path(name, "meta.json"))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="+")
    parser.add_argument("--linear", action="store_true", help="tetrahedra of four nodes")
    options = parser.parse_args()
    for component_name in options.names:
        print(json.dumps(generate(component_name + ("-linear" if options.linear else ""))), flush=True)
