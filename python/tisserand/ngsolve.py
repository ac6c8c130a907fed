"""Parts of NGSolve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from tisserand import _native


@dataclass(frozen=True)
class Part:
    """Nodes and rows of a displacement field, as :func:`tisserand.reduce` takes them. Made by :func:`part`."""

    points: NDArray[np.float64]
    """Places of the vertices, (n, 2) or (n, 3), in the unit of length of the mesh."""
    dofs: list[tuple[int | None, str]]
    """Vertex and direction of each row; the functions of higher order on edges, faces and cells belong to no node."""
    _regions: Any

    def nodes(self, boundary: str) -> NDArray[np.int64]:
        """Vertices of a named boundary.

        Parameters
        ----------
        boundary
            Name of a boundary of the mesh.

        Returns
        -------
        ndarray
            Vertices counted from 0, (k), whole numbers, rising: nodes of an interface for :func:`tisserand.reduce`.

        Raises
        ------
        InputError
            The mesh has no such boundary.
        """
        found = sorted({vertex.nr for element in self._regions.Boundaries(boundary).Elements() for vertex in element.vertices})
        if not found:
            raise _native.InputError(f"the mesh has no boundary {boundary!r}; it has {', '.join(sorted(set(self._regions.GetBoundaries())))}")
        return np.array(found, dtype=np.int64)

    def arguments(self) -> dict[str, Any]:
        """`points` and `dofs` of :func:`tisserand.reduce`.

        Returns
        -------
        dict
            :attr:`points` and :attr:`dofs` by these names.
        """
        return {"points": self.points, "dofs": self.dofs}


def part(space: Any) -> Part:
    """Nodes and rows of a space of displacements.

    Parameters
    ----------
    space
        `ngsolve.VectorH1(mesh, order=...)` of any order, without Dirichlet conditions. Its functions of higher order vanish in rigid motions, so
        their rows are internal ones.

    Returns
    -------
    Part
        Vertices as nodes, and the node and direction of each row.
    """
    mesh = space.mesh
    if space.FreeDofs().NumSet() != space.ndof:
        raise _native.InputError("space: has Dirichlet conditions; a superelement is a free part, so make the space without them")
    names, count = ("ux", "uy", "uz")[: mesh.dim], mesh.nv
    if len(space.components) != mesh.dim:
        raise _native.InputError(f"space: has {len(space.components)} components in {mesh.dim}-D; expected VectorH1")
    dofs: list[tuple[int | None, str]] = [(None, "internal")] * space.ndof
    for axis, name in enumerate(names):
        first = space.Range(axis).start
        for vertex in range(count):
            dofs[first + vertex] = (vertex, name)
    points = np.array([vertex.point for vertex in mesh.vertices])
    return Part(points, dofs, mesh)


def matrix(form: Any) -> scipy.sparse.csr_array:
    """The matrix of an assembled `BilinearForm`, both triangles.

    Parameters
    ----------
    form
        An `ngsolve.BilinearForm` that is assembled.

    Returns
    -------
    scipy.sparse.csr_array
        Stiffness or mass for :func:`tisserand.reduce`, (n_e, n_e), a copy.
    """
    # Copies: NGSolve's arrays go with the form.
    values, columns, starts = (np.array(array) for array in form.mat.CSR())
    size = form.mat.height
    return scipy.sparse.csr_array((values, columns, starts), shape=(size, size))
