"""Meshes of meshio: what goes into a reduction, and superelements as meshes with their modes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tisserand import _native
from tisserand.superelement import Superelement


def arguments(mesh: Any) -> dict[str, Any]:
    """`points` and `cells` of :func:`tisserand.reduce` from a `meshio.Mesh`.

    Parameters
    ----------
    mesh
        A `meshio.Mesh`. Its lengths are in the part's unit of length.

    Returns
    -------
    dict
        `points`, the places of the nodes as the mesh has them, (n, 2) or (n, 3), and `cells`, a list of names and nodes, (m, k), of the blocks of
        cells.
    """
    return {"points": np.asarray(mesh.points), "cells": [(block.type, np.asarray(block.data)) for block in mesh.cells]}


def nodes(mesh: Any, name: str) -> NDArray[np.int64]:
    """Nodes of a named set of a `meshio.Mesh`: its point set, or the nodes of its cell set.

    Parameters
    ----------
    mesh
        A `meshio.Mesh`.
    name
        Name of a point set or a cell set; a point set goes first.

    Returns
    -------
    ndarray
        Nodes counted from 0, (k), whole numbers. Those of a cell set are rising, each once.

    Raises
    ------
    InputError
        The mesh has no set of this name.
    """
    if name in mesh.point_sets:
        return np.asarray(mesh.point_sets[name], dtype=np.int64)
    if name in mesh.cell_sets:
        chosen = mesh.cell_sets[name]
        blocks = [block.data[which].ravel() for block, which in zip(mesh.cells, chosen, strict=True) if which is not None and len(which)]
        return np.unique(np.concatenate(blocks)) if blocks else np.array([], dtype=np.int64)
    known = sorted([*mesh.point_sets, *mesh.cell_sets])
    raise _native.InputError(f"the mesh has no set {name!r}; it has {', '.join(known) or 'none'}")


def mesh(part: Superelement, modes: Sequence[int] = ()) -> Any:
    """A `meshio.Mesh` of a superelement, with the shapes of some modes as point data `mode 1`, `mode 2` and so on.

    Parameters
    ----------
    part
        A superelement with its mesh, and with its nodal fields where modes are wanted.
    modes
        Modes counted from 0: mode 0 becomes `mode 1`. None by default.

    Returns
    -------
    meshio.Mesh
        The undeformed part in its own coordinates, in its unit of length. The shapes, (n, 3) each, are mass-normalized as :meth:`Superelement.shape`
        says.
    """
    import meshio

    points = part.points
    if points is None:
        raise _native.InputError(f"{part.name}: has no mesh; ask for the whole file")
    shapes = {f"mode {mode + 1}": part.shape(mode) for mode in modes}
    return meshio.Mesh(points, part.cells, point_data=shapes)
