"""Parts of scikit-fem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tisserand import _native


@dataclass(frozen=True)
class Part:
    """Nodes and rows of a displacement field, as :func:`tisserand.reduce` takes them. Made by :func:`part`."""

    points: NDArray[np.float64]
    """Places of the nodes, (n, 2) or (n, 3): vertices first, then edges, facets and interiors, as the element has them."""
    dofs: list[tuple[int, str]]
    """Node and direction of each row of the matrices."""
    cells: dict[str, NDArray[np.int64]]
    """The cells' vertices by meshio's names; empty without meshio."""

    def nodes(self, where: Any) -> NDArray[np.int64]:
        """Nodes at which a function of the places, (dim, n), is true.

        Parameters
        ----------
        where
            Called with the places of the nodes, (dim, n), one row for each direction; gives an array of booleans, (n).

        Returns
        -------
        ndarray
            Nodes counted from 0, (k), whole numbers, rising: those of an interface for :func:`tisserand.reduce`.

        Raises
        ------
        InputError
            No node is there.
        """
        found = np.flatnonzero(where(self.points.T))
        if len(found) == 0:
            raise _native.InputError("no node is there; compare coordinates with a tolerance, as in abs(x[0]) < 1e-9")
        return found

    def arguments(self) -> dict[str, Any]:
        """`points`, `dofs` and `cells` of :func:`tisserand.reduce`.

        Returns
        -------
        dict
            :attr:`points`, :attr:`dofs` and :attr:`cells` by these names.
        """
        return {"points": self.points, "dofs": self.dofs, "cells": self.cells}


def part(basis: Any) -> Part:
    """Nodes and rows of a basis of displacements: `Basis(mesh, ElementVector(...))` of any order.

    Parameters
    ----------
    basis
        `skfem.Basis` of an `ElementVector` of a nodal element.

    Returns
    -------
    Part
        Nodes, the node and direction of each row, and cells.
    """
    dim = basis.mesh.dim()
    count = basis.N
    node_of = np.full(count, -1, dtype=np.int64)
    direction = np.zeros(count, dtype=np.int64)
    points: list[NDArray[np.float64]] = []
    held = 0
    for group in (basis.nodal_dofs, basis.edge_dofs if dim == 3 else None, basis.facet_dofs, basis.interior_dofs):
        if group is None or np.size(group) == 0:
            continue
        if group.shape[0] % dim:
            raise _native.InputError(f"basis: has {group.shape[0]} values on an entity in {dim}-D; expected an ElementVector of displacements")
        for first in range(0, group.shape[0], dim):
            block = group[first : first + dim]
            used = np.flatnonzero(block[0] >= 0)
            nodes = held + np.arange(len(used))
            for axis in range(dim):
                node_of[block[axis, used]] = nodes
                direction[block[axis, used]] = axis
            points.append(basis.doflocs[:, block[0, used]].T)
            held += len(used)
    if np.any(node_of < 0):
        raise _native.InputError("basis: has rows of no vertex, edge, facet or interior; expected an ElementVector of displacements")
    names = ("ux", "uy", "uz")
    dofs = [(int(node), names[axis]) for node, axis in zip(node_of, direction, strict=True)]
    return Part(np.concatenate(points), dofs, _cells(basis.mesh))


def _cells(mesh: Any) -> dict[str, NDArray[np.int64]]:
    try:
        from skfem.io.meshio import to_meshio
    except ImportError:
        return {}
    return {block.type: np.asarray(block.data, dtype=np.int64) for block in to_meshio(mesh).cells if block.dim == mesh.dim()}
