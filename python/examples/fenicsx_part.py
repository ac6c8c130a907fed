"""A solid of FEniCSx as a superelement: a bar of aluminium, 0.5 m x 20 mm x 10 mm, of quadratic hexahedra."""

import numpy as np
import tisserand
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import assemble_matrix
from mpi4py import MPI
from scipy.sparse import csr_matrix

bar = mesh.create_box(MPI.COMM_SELF, [[0, -0.01, -0.005], [0.5, 0.01, 0.005]], [40, 3, 2], mesh.CellType.hexahedron)
space = fem.VectorFunctionSpace(bar, ("CG", 2))   # from dolfinx 0.7 on: fem.functionspace(bar, ("CG", 2, (3,)))
u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
young, poisson, density = 70e9, 0.33, 2700.0
first, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
strain = lambda w: ufl.sym(ufl.grad(w))
stress = lambda w: first * ufl.tr(strain(w)) * ufl.Identity(3) + 2 * shear * strain(w)


def matrix(form):
    assembled = assemble_matrix(fem.form(form))
    assembled.assemble()
    pointers, columns, values = assembled.getValuesCSR()
    return csr_matrix((values, columns, pointers))


K, M = matrix(ufl.inner(stress(u), strain(v)) * ufl.dx), matrix(density * ufl.inner(u, v) * ufl.dx)
points = space.tabulate_dof_coordinates()         # a point for each block of three rows
ends = {"left": np.flatnonzero(abs(points[:, 0]) < 1e-9), "right": np.flatnonzero(abs(points[:, 0] - 0.5) < 1e-9)}
arm = tisserand.reduce(K, M, points, ends, modes=8, name="arm")
print(arm)
print(arm.frequencies[:3])
