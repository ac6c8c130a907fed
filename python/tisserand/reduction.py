"""Reductions of matrices in memory."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tisserand import _checks, _native
from tisserand.scene import Scene, scene_of
from tisserand.superelement import Superelement


def reduce(
    K: Any,
    M: Any,
    points: ArrayLike,
    interfaces: Mapping[str, Any] | Sequence[Mapping[str, Any]],
    *,
    modes: int | None = None,
    max_frequency: float | None = None,
    dofs: Sequence[Any] | None = None,
    cells: Mapping[str, ArrayLike] | Sequence[tuple[str, ArrayLike]] | None = None,
    loads: Mapping[str, ArrayLike] | None = None,
    boundary: Any = None,
    component_masses: Mapping[str, Any] | None = None,
    stiffening: Mapping[str, Any] | None = None,
    units: Sequence[str] | Mapping[str, str] = ("m", "kg", "s"),
    name: str = "part",
    damping: float | Sequence[float] | Mapping[str, Any] | None = None,
    interface_modes: int | None = None,
    enrich: Sequence[str] = (),
    without_estimate: bool = False,
    allow_grounded: bool = False,
    allow_loose: bool = False,
    sturm_check: bool = False,
    scene: Scene | Mapping[str, Any] | str | PathLike[str] | None = None,
    bodies: Sequence[str] = (),
    tolerance: float = 1e-3,
    keep_all: bool = False,
    memory: str | int | None = None,
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
        Where forces act and motion is observed, by name: nodes counted from 0 as a list, array, range or set, or a mapping with `nodes` and what a
        component file may have besides: `kind` (`"average"`, the default here, `"rigid"` or `"nodes"`), `position`, `weights`, `axes`, `dofs`,
        `role`.
    modes
        Elastic modes to keep, 30 where nothing is said; a multiple root stays whole. With `scene` the most that may be kept.
    max_frequency
        Keep every mode below this frequency instead, in Hz.
    dofs
        Directions of every node, row after row: `["ux", "uy", "uz"]` by default, `["ux", "uy"]` for planar points. Or a table with an entry
        `[node, "ux"]` for each row, `[None, "internal"]` for one of no node.
    cells
        Nodes of the cells, (m, k) each, by meshio's names: for pictures.
    loads
        Forces on the inside by name, (n_e) each.
    boundary
        Further rows of L_b, (n, n_e), sparse or dense: combinations of degrees of freedom that are observed and loaded.
    component_masses
        Masses by pairs of axes, `"xx"`, `"yy"`, `"zz"`, `"xy"`, `"yz"`, `"zx"` (planar `"xx"`, `"yy"`, `"xy"`), (n_e, n_e) each: exact inertia of
        beams and shells.
    stiffening
        Geometric stiffness, (n_e, n_e) each: by products of spins, such as `"zz"`, in (rad/time)², and by rows, such as `"hub.ux"`, for a unit force.
    units
        Names of the units of length, mass and time, in this order or by these words; metres, kilograms and seconds by default.
    name
        Name of the part, which the superelement and messages have.
    damping
        Ratio to critical of all modes, one for each, or what a component file may have. None by default.
    interface_modes, enrich, without_estimate, allow_grounded, allow_loose, sturm_check
        As the options of the program `reduce`.
    scene, bodies, tolerance, keep_all
        Keep what this scene asks of its bodies, within a relative error of the part's responses, and leave out the rest, or nothing with `keep_all`:
        `docs/scene-driven.md`. Bodies are by default those of a file `NAME.dcb.h5`; the file needn't be there.
    memory
        How much may be taken, as `"8G"` or in bytes; by default what the machine has available.
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
        The reduced part, in the units of the part, with its nodal shapes and its mesh; with `scene` those of the nodes that the scene looks at, if
        any.

    Raises
    ------
    InputError
        What was given can't be used.
    NumericalError
        The computation failed, or its result doesn't keep its limits.
    KeyboardInterrupt
        Ctrl-C ends the reduction when the block of work that it is in is over; a factorization is one block.
    """
    part = _part(K, M, points, interfaces, dofs, cells, loads, units, name, damping, boundary, component_masses, stiffening)
    options: dict[str, Any] = {
        "enrich": _enrichment("enrich", enrich),
        "without_estimate": without_estimate,
        "allow_grounded": allow_grounded,
        "allow_loose": allow_loose,
        "sturm_check": sturm_check,
    }
    if interface_modes is not None:
        options["interface_modes"] = _checks.whole_number("interface_modes", interface_modes)
    _checks.function("progress", progress)
    wanted = None
    if scene is not None:
        if max_frequency is not None or interface_modes is not None or without_estimate:
            raise _native.InputError("scene: decides on max_frequency, interface_modes and the estimate itself; leave them out")
        described = scene_of(scene)
        wanted = {
            "scene": described._checked(),
            "path": fspath(described._folder / described._path),
            "bodies": _checks.names("bodies", bodies, '["arm"]'),
            "file": fspath(described._folder / f"{name.replace('/', '_')}.dcb.h5"),
            "tolerance": _checks.share("tolerance", tolerance),
            "keep_all": bool(keep_all),
            "modes": _checks.optional_whole_number("modes", modes),
        }
    means = _means(memory, factor, scratch, _modes(modes, max_frequency))
    return Superelement(_native.reduce(part, _json(options), means, wanted, progress, _threads(threads)))


@dataclass(frozen=True)
class Plan:
    """What a reduction will cost. Made by :func:`plan`."""

    dofs: int
    """Dofs of the model that is factorized."""
    modes: int
    """Elastic modes wanted; with `max_frequency`, which doesn't say how many there are, a guess."""
    attachments: int
    """Attachments, one for each of the n_b boundary rows."""
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
    modes: int | None = None,
    max_frequency: float | None = None,
    dofs: Sequence[Any] | None = None,
    boundary: Any = None,
    units: Sequence[str] | Mapping[str, str] = ("m", "kg", "s"),
) -> Plan:
    """Say what :func:`reduce` will cost, from the pattern of the matrices alone; parameters as there.

    Parameters
    ----------
    K, M
        Stiffness and mass of the free part, both triangles, (n_e, n_e).
    points
        Places of the nodes, (n, 3), or (n, 2) for a planar part.
    interfaces
        Nodes by name, or more of each interface.
    modes
        Elastic modes to keep, 30 where nothing is said.
    max_frequency
        Keep every mode below this frequency instead, in Hz.
    dofs
        Directions of every node, or a table with an entry for each row.
    boundary
        Further rows of L_b, (n, n_e), sparse or dense.
    units
        Names of the units of length, mass and time; metres, kilograms and seconds by default.

    Returns
    -------
    Plan
        Sizes, operations and memory.
    """
    part = _part(K, M, points, interfaces, dofs, None, None, units, "part", None, boundary)
    return Plan(**json.loads(_native.plan(part, _means(None, "auto", None, _modes(modes, max_frequency)))))


def _modes(modes: int | None, max_frequency: float | None) -> dict[str, Any]:
    if max_frequency is not None:
        return {"modes": None, "max_frequency": _checks.positive("max_frequency", max_frequency, "Hz")}
    return {"modes": 30 if modes is None else _checks.whole_number("modes", modes), "max_frequency": None}


ENRICHMENTS = ("spin", "loads", "krylov")


def _enrichment(name: str, sources: Sequence[str]) -> list[str]:
    found = _checks.names(name, sources, '["spin"]')
    return [_checks.one_of(name, source, ENRICHMENTS) for source in found]


def _threads(threads: int | None) -> int | None:
    return _checks.optional_whole_number("threads", threads, 1)


FACTORS = ("auto", "memory", "single", "disk")


def _means(memory: str | int | None, factor: str, scratch: str | PathLike[str] | None, modes: dict[str, Any]) -> str:
    folder = tempfile.gettempdir() if scratch is None else fspath(scratch)
    room = memory if memory is None or isinstance(memory, str) else str(_checks.whole_number("memory", memory, 1))
    return _json(modes | {"memory": room, "factor": _checks.one_of("factor", factor, FACTORS), "scratch": folder})


def _part(
    K: Any,
    M: Any,
    points: ArrayLike,
    interfaces: Mapping[str, Any] | Sequence[Mapping[str, Any]],
    dofs: Sequence[Any] | None,
    cells: Mapping[str, ArrayLike] | Sequence[tuple[str, ArrayLike]] | None,
    loads: Mapping[str, ArrayLike] | None,
    units: Sequence[str] | Mapping[str, str],
    name: str,
    damping: float | Sequence[float] | Mapping[str, Any] | None,
    boundary: Any = None,
    component_masses: Mapping[str, Any] | None = None,
    stiffening: Mapping[str, Any] | None = None,
) -> _native._Part:
    try:
        places = np.asarray(points)
    except ValueError:
        raise _native.InputError("points: its rows differ in length, expected (n, 3) or (n, 2)") from None
    if dofs is None:
        dofs = ["ux", "uy"] if places.ndim == 2 and places.shape[1] == 2 else ["ux", "uy", "uz"]
    description: dict[str, Any] = {
        "name": name,
        "units": _checks.units_of(units),
        "dofs": list(dofs),
        "interfaces": _interfaces(interfaces),
    }
    if damping is not None:
        description["damping"] = damping if isinstance(damping, Mapping) else {"modal": damping}
    return {
        "stiffness": K,
        "mass": M,
        "points": places,
        "description": _json(description),
        "cells": list(cells.items()) if isinstance(cells, Mapping) else list(cells or []),
        "loads": list((loads or {}).items()),
        "boundary": boundary,
        "component_masses": list((component_masses or {}).items()),
        "stiffening": list((stiffening or {}).items()),
    }


def _interfaces(interfaces: Mapping[str, Any] | Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]]
    if isinstance(interfaces, Mapping):
        named = [{"name": name} | (dict(what) if isinstance(what, Mapping) else {"nodes": what}) for name, what in interfaces.items()]
        found = [{"kind": "average"} | described for described in named]
    else:
        expected = 'expected nodes by name, such as {"left": [0, 1, 2, 3]}'
        if not isinstance(interfaces, Iterable) or isinstance(interfaces, str):
            raise _native.InputError(f"interfaces: are {interfaces!r}, {expected}")
        listed = list(interfaces)
        for interface in listed:
            if not isinstance(interface, Mapping):
                raise _native.InputError(f"interfaces: have {interface!r} without a name, {expected}")
        found = [dict(interface) for interface in listed]
    for described in found:
        if "nodes" in described:
            described["nodes"] = _nodes(described.get("name"), described["nodes"])
    return found


def _nodes(name: Any, nodes: Any) -> list[int]:
    expected = "expected nodes counted from 0"
    if isinstance(nodes, str) or not isinstance(nodes, Iterable):
        raise _native.InputError(f"interfaces[{name!r}]: is {nodes!r}, {expected}")
    numbers = np.asarray(sorted(nodes) if isinstance(nodes, Set) else nodes if isinstance(nodes, np.ndarray) else list(nodes))
    if numbers.dtype == bool:
        raise _native.InputError(f"interfaces[{name!r}]: is a mask, {expected}; np.flatnonzero makes them of a mask")
    if numbers.size and (numbers.ndim != 1 or numbers.dtype.kind not in "iu"):
        raise _native.InputError(f"interfaces[{name!r}]: is an array of {numbers.dtype} with {numbers.ndim} axes, {expected}")
    if numbers.size and numbers.min() < 0:
        raise _native.InputError(f"interfaces[{name!r}]: has {numbers.min()}, {expected}")
    found: list[int] = numbers.tolist()
    return found


def _json(value: Any) -> str:
    try:
        return json.dumps(value, default=_plain, allow_nan=False)
    except ValueError:
        raise _native.InputError("damping, interfaces or dofs: have a number that isn't finite") from None


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as JSON has them."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise _native.InputError(f"{value!r} is no part of a description")
