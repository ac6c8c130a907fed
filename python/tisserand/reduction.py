"""Reductions of matrices in memory."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tisserand import _native
from tisserand.superelement import Superelement


def reduce(
    K: Any,
    M: Any,
    points: ArrayLike,
    interfaces: Mapping[str, Any] | Sequence[Mapping[str, Any]],
    *,
    modes: int = 30,
    max_frequency: float | None = None,
    dofs: Sequence[Any] | None = None,
    cells: Mapping[str, ArrayLike] | Sequence[tuple[str, ArrayLike]] | None = None,
    loads: Mapping[str, ArrayLike] | None = None,
    units: tuple[str, str, str] = ("m", "kg", "s"),
    name: str = "part",
    damping: float | Sequence[float] | Mapping[str, Any] | None = None,
    interface_modes: int | None = None,
    enrich: Sequence[str] = (),
    without_estimate: bool = False,
    allow_grounded: bool = False,
    allow_loose: bool = False,
    memory: str | None = None,
    factor: str = "auto",
    scratch: str | PathLike[str] | None = None,
    progress: Callable[[str, float], object] | None = None,
    threads: int | None = None,
) -> Superelement:
    """Reduce a free part to a superelement.

    Parameters
    ----------
    K, M
        Stiffness and mass of the free part, both triangles, (n_e, n_e): SciPy's sparse matrices or arrays in any format, or dense arrays.
        In consistent units: with metres, kilograms and seconds newtons per metre and kilograms.
    points
        Places of the nodes, (n, 3), or (n, 2) for a planar part.
    interfaces
        Where forces act and motion is observed, by name: a list of nodes counted from 0, or a mapping with `nodes` and what a component file may
        have besides: `kind` (`"average"`, the default here, `"rigid"` or `"nodes"`), `position`, `weights`, `axes`, `dofs`, `role`.
    modes
        Elastic modes to keep; a multiple root stays whole.
    max_frequency
        Keep every mode below this frequency instead, in Hz.
    dofs
        Directions of every node, row after row: `["ux", "uy", "uz"]` by default, `["ux", "uy"]` for planar points. Or a table with an entry
        `[node, "ux"]` for each row, `[None, "internal"]` for one of no node.
    cells
        Nodes of the cells, (m, k) each, by meshio's names: for pictures.
    loads
        Forces on the inside by name, (n_e) each.
    units
        Length, mass and time.
    damping
        Ratio to critical of all modes, one for each, or what a component file may have.
    interface_modes, enrich, without_estimate, allow_grounded, allow_loose
        As the options of the program `reduce`.
    memory
        How much may be taken, as `"8G"`; by default what the machine has available.
    factor
        Where the factor is kept: `"auto"`, `"memory"`, `"single"` (half the room) or `"disk"`.
    scratch
        Folder of a factor on disk; by default that of temporary files.
    progress
        Called with the stage and how much of it is done, 0 to 1, from another thread. What it raises ends the reduction.
    threads
        Worker threads; all processors by default. Results don't depend on it.

    Returns
    -------
    Superelement

    Raises
    ------
    InputError
        What was given can't be used.
    NumericalError
        The computation failed, or its result doesn't keep its limits.
    KeyboardInterrupt
        Ctrl-C ends the reduction when the block of work that it is in is over; a factorization is one block.
    """
    part = _part(K, M, points, interfaces, dofs, cells, loads, units, name, damping)
    options: dict[str, Any] = {
        "enrich": list(enrich),
        "without_estimate": without_estimate,
        "allow_grounded": allow_grounded,
        "allow_loose": allow_loose,
    }
    if interface_modes is not None:
        options["interface_modes"] = interface_modes
    return Superelement(_native.reduce(part, _json(options), _means(memory, factor, scratch, _modes(modes, max_frequency)), progress, threads))


@dataclass(frozen=True)
class Plan:
    """What a reduction will cost."""

    dofs: int
    """Dofs of the model that is factorized."""
    modes: int
    attachments: int
    factor_entries: int
    """Entries of the factor's lower triangle."""
    operations: float
    """Multiplications and additions of a factorization, each pair one."""
    memory: int
    """Most memory with the factor in memory, bytes, give or take a fifth."""


def plan(
    K: Any,
    M: Any,
    points: ArrayLike,
    interfaces: Mapping[str, Any] | Sequence[Mapping[str, Any]],
    *,
    modes: int = 30,
    max_frequency: float | None = None,
    dofs: Sequence[Any] | None = None,
    units: tuple[str, str, str] = ("m", "kg", "s"),
) -> Plan:
    """Say what :func:`reduce` will cost, from the pattern of the matrices alone."""
    part = _part(K, M, points, interfaces, dofs, None, None, units, "part", None)
    return Plan(**json.loads(_native.plan(part, _means(None, "auto", None, _modes(modes, max_frequency)))))


def _modes(modes: int, max_frequency: float | None) -> dict[str, Any]:
    if modes < 0:
        raise _native.InputError(f"modes: is {modes}, expected 0 or more")
    if max_frequency is not None and not max_frequency > 0:
        raise _native.InputError(f"max_frequency: is {max_frequency}, expected a positive number of Hz")
    return {"modes": modes if max_frequency is None else None, "max_frequency": max_frequency}


FACTORS = ("auto", "memory", "single", "disk")


def _means(memory: str | None, factor: str, scratch: str | PathLike[str] | None, modes: dict[str, Any]) -> str:
    if factor not in FACTORS:
        raise _native.InputError(f"factor: is {factor!r}, expected one of {', '.join(FACTORS)}")
    folder = tempfile.gettempdir() if scratch is None else fspath(scratch)
    return _json(modes | {"memory": memory, "factor": factor, "scratch": folder})


def _part(
    K: Any,
    M: Any,
    points: ArrayLike,
    interfaces: Mapping[str, Any] | Sequence[Mapping[str, Any]],
    dofs: Sequence[Any] | None,
    cells: Mapping[str, ArrayLike] | Sequence[tuple[str, ArrayLike]] | None,
    loads: Mapping[str, ArrayLike] | None,
    units: tuple[str, str, str],
    name: str,
    damping: float | Sequence[float] | Mapping[str, Any] | None,
) -> _native._Part:
    places = np.asarray(points)
    if dofs is None:
        dofs = ["ux", "uy"] if places.ndim == 2 and places.shape[1] == 2 else ["ux", "uy", "uz"]
    description: dict[str, Any] = {
        "name": name,
        "units": dict(zip(("length", "mass", "time"), units, strict=True)),
        "dofs": list(dofs),
        "interfaces": _interfaces(interfaces),
    }
    if damping is not None:
        description["damping"] = damping if isinstance(damping, Mapping) else {"modal": damping}
    blocks = list(cells.items()) if isinstance(cells, Mapping) else list(cells or [])
    return (K, M, places, _json(description), blocks, list((loads or {}).items()))


def _interfaces(interfaces: Mapping[str, Any] | Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    if not isinstance(interfaces, Mapping):
        return [dict(interface) for interface in interfaces]
    found = []
    for name, what in interfaces.items():
        described = dict(what) if isinstance(what, Mapping) else {"nodes": what}
        found.append({"name": name, "kind": "average"} | described)
    return found


def _json(value: Any) -> str:
    try:
        return json.dumps(value, default=_plain, allow_nan=False)
    except ValueError as error:
        raise _native.InputError(str(error)) from None


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as JSON has them."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise _native.InputError(f"{value!r} is no part of a description")
