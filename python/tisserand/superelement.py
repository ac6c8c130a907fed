"""Superelements: what a part does at its interfaces."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tisserand import _checks, _native


@dataclass(frozen=True)
class ErrorBounds:
    """Bounds of the relative errors of a superelement below a frequency; each is (lower, upper), but for the last.

    Made by :meth:`Superelement.errors`. `docs/error-estimate.md` says what they mean.
    """

    max_frequency: float
    """Upper end of the band, Hz, or cycles per unit of time where that isn't known."""
    static_response: tuple[float, float]
    """Static response with the inertia relieved, of the worst interface."""
    collocated: tuple[float, float]
    """Largest error over the band of the response of each interface at itself."""
    transfer: tuple[float, float] | None
    """Largest error over the band of the response between different interfaces; `None` where there is one interface."""
    held_frequency: tuple[float, float] | None
    """Largest error of a natural frequency in the band with all interface rows held, 1 for one that is lacking; `None` where none can be there."""
    free_frequency: float
    """Upper bound of the errors of the kept free frequencies."""


@dataclass(frozen=True)
class Verification:
    """What can be recomputed of a superelement, and what doesn't agree: it is false where something doesn't. Made by :meth:`Superelement.verify`."""

    text: str
    """A line for each number that was recomputed, with its deviation and its limit."""
    broken: list[str]
    """What doesn't agree; empty where all does."""

    def __bool__(self) -> bool:
        return not self.broken


class Superelement:
    """A reduced part. Large arrays are read-only views that keep it alive; coordinates are of the body frame, units those of :attr:`units`.

    Made by :func:`reduce`, :meth:`read` and :meth:`select`. It has n_k modes, n_b boundary rows, and n_f rows of nodal shapes. The axes of the body
    frame are parallel to those of the part's own coordinates; its origin is the centre of mass.
    """

    __slots__ = ("_native",)

    def __init__(self, native: _native.Superelement) -> None:
        self._native = native

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Superelement:
        """Read a file `.dcb.h5`, with its nodal fields and its mesh where it has them.

        Parameters
        ----------
        path
            The file.

        Returns
        -------
        Superelement
            What is in the file, in memory.
        """
        return cls(_native.Superelement.read(path))

    def write(
        self, path: str | PathLike[str], *, overwrite: bool = False, fields: bool = True, mesh: bool = True, compress: bool = False
    ) -> None:
        """Write a file, whole or not at all.

        Parameters
        ----------
        path
            The file, `NAME.dcb.h5`.
        overwrite
            Replace one that exists; by default it is refused.
        fields, mesh
            Whether the nodal shapes and the mesh go into it; without both it says nothing of the inside of the part.
        compress
            Compress the nodal shapes: slower, a little smaller.
        """
        self._native.write(path, overwrite=overwrite, fields=fields, mesh=mesh, compress=compress)

    @property
    def name(self) -> str:
        """Name of the part."""
        return self._native.name

    @property
    def units(self) -> tuple[str, str, str]:
        """Names of the units of length, mass and time."""
        return self._native.units

    @property
    def mass(self) -> float:
        """Total mass, in the unit of mass."""
        return self._native.mass

    @property
    def centre_of_mass(self) -> NDArray[np.float64]:
        """Centre of mass in the part's own coordinates, (3), length."""
        return np.array(self._native.origin)

    @property
    def inertia(self) -> NDArray[np.float64]:
        """Inertia about the centre of mass, (3, 3), mass * length²; a planar part has only the last entry."""
        return np.array(self._native.inertia)

    @property
    def interfaces(self) -> list[str]:
        """Names of the interfaces."""
        return self._native.interfaces

    @property
    def rows(self) -> list[str]:
        """Names of the n_b boundary rows, such as `hub.ux`."""
        return self._native.rows

    @property
    def warnings(self) -> list[str]:
        """What the reduction has warned of."""
        return self._native.warnings

    @property
    def eigenvalues(self) -> NDArray[np.float64]:
        """Squares ω² of the angular frequencies of the kept free modes, (n_k), (rad/time)², rising."""
        return self._native.eigenvalues

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Frequencies of the kept free modes, (n_k), Hz, or cycles per unit of time where that isn't known, rising."""
        return np.sqrt(self.eigenvalues) / (2.0 * math.pi * self._native.second)

    @property
    def interface_shapes(self) -> NDArray[np.float64]:
        """The kept modes, mass-normalized, at the boundary rows, L_b Φ, (n_b, n_k)."""
        return self._native.interface_shapes

    @property
    def residual_flexibility(self) -> NDArray[np.float64]:
        """Residual flexibility of the boundary rows, F_res, (n_b, n_b), displacement of a row by force on a row."""
        return self._native.residual_flexibility

    @property
    def residual_mass(self) -> NDArray[np.float64]:
        """Residual mass: that of the attachments, M_res, (n_b, n_b)."""
        return self._native.residual_mass

    @property
    def modes(self) -> NDArray[np.float64] | None:
        """Nodal shapes of the kept modes, mass-normalized, Φ, (n_f, n_k); rows as :attr:`field_dofs` says; `None` without nodal fields."""
        return self._native.modes

    @property
    def attachments(self) -> NDArray[np.float64] | None:
        """Nodal shapes of the attachments, G_res L_bᵀ, (n_f, n_b); rows as :attr:`field_dofs` says; `None` without nodal fields."""
        return self._native.attachments

    @property
    def field_dofs(self) -> NDArray[np.int64] | None:
        """Node and direction of each row of the nodal shapes, (n_f, 2); directions are 0 to 5, `ux` to `rz`."""
        dofs = self._native.field_dofs
        return None if dofs is None else np.array(dofs, dtype=np.int64).reshape(-1, 2)

    @property
    def points(self) -> NDArray[np.float64] | None:
        """Places of the nodes in the part's own coordinates, (n, 3) or (n, 2), length; `None` without a mesh."""
        return self._native.points

    @property
    def cells(self) -> list[tuple[str, NDArray[np.int64]]]:
        """Meshio's name and nodes counted from 0, (m, k), of each block of cells; empty without a mesh."""
        return [(kind, np.array(nodes, dtype=np.int64)) for kind, nodes in self._native.cells]

    def shape(self, mode: int) -> NDArray[np.float64]:
        """Displacements of the nodes in a mode, (n, 3).

        Parameters
        ----------
        mode
            The mode, counted from 0.

        Returns
        -------
        ndarray
            Displacements along x, y and z of a mode of unit modal mass, (n, 3), in 1/√mass. Along z they are zero in a planar part.

        Raises
        ------
        InputError
            The superelement has no nodal fields, no mesh, or no such mode.
        """
        dofs, modes, points = self.field_dofs, self.modes, self.points
        if dofs is None or modes is None or points is None:
            raise _native.InputError(f"{self.name}: has no nodal fields or no mesh; reduce it again, or ask for the whole file")
        if not 0 <= mode < modes.shape[1]:
            raise _native.InputError(f"mode: is {mode}, expected 0 to {modes.shape[1] - 1}")
        shape = np.zeros((len(points), 3))
        moves = dofs[:, 1] < 3
        shape[dofs[moves, 0], dofs[moves, 1]] = modes[moves, mode]
        return shape

    def errors(
        self, max_frequency: float | None = None, *, compatibility: Literal["strong", "static"] = "strong", points: int = 400
    ) -> ErrorBounds | None:
        """Bounds of the relative errors, from the superelement alone.

        Parameters
        ----------
        max_frequency
            Upper end of the band, Hz; half the highest frequency where nothing is said, or half the first one left out where that is lower. It must
            be below the first one left out.
        compatibility
            Form in which the superelement is used: `"strong"`, the default, or `"static"`.
        points
            Number of frequencies at which the bounds are computed, 400 by default; resonances are added.

        Returns
        -------
        ErrorBounds or None
            `None` where the superelement has no error moments: those of files before format 1.2, of reductions `without_estimate`, and those with
            further columns that :meth:`select` gives with fewer modes.
        """
        second = 2.0 * math.pi * self._native.second
        upper = None if max_frequency is None else (second * _checks.positive("max_frequency", max_frequency, "Hz")) ** 2
        if not 1 <= _checks.whole_number("points", points, 1) <= 1_000_000:
            raise _native.InputError(f"points: is {points}, expected 1 to 1000000")
        _checks.one_of("compatibility", compatibility, ("strong", "static"))
        found = self._native.error_bounds(upper, compatibility, points)
        if found is None:
            return None
        top = math.sqrt(found.pop("upper_eigenvalue")) / second
        return ErrorBounds(max_frequency=top, **found)

    def verify(self) -> Verification:
        """Recompute what can be recomputed of the superelement alone.

        Returns
        -------
        Verification
            What was recomputed; false where something doesn't agree.
        """
        return Verification(*self._native.check())

    def inspect(self) -> dict[str, Any]:
        """All that `reduce inspect --json` says of it; `print(part)` says less.

        Returns
        -------
        dict
            Numbers, texts and lists by name, such as `frequencies_hz`, `interfaces`, `errors` and `quality`.
        """
        with self._file() as path:
            found: dict[str, Any] = json.loads(_native.inspected(path, True))
        return found

    def compare(self, other: Superelement) -> str:
        """How far two superelements agree: frequencies, shapes, flexibility, mass; a table for people, in SI units.

        Parameters
        ----------
        other
            The superelement to compare with.

        Returns
        -------
        str
            The table, as `reduce compare` prints it. In it A is this superelement and B the other one.
        """
        if not isinstance(other, Superelement):
            raise _native.InputError(f"other: is {other!r}, expected a superelement; Superelement.read reads a file")
        with self._file() as own, other._file() as others:
            return _native.compared(own, others)

    @contextmanager
    def _file(self) -> Iterator[Path]:
        with tempfile.TemporaryDirectory(prefix="tisserand-") as folder:
            path = Path(folder) / f"{self.name.replace('/', '_')}.dcb.h5"
            self.write(path)
            yield path

    def select(self, *, modes: int) -> Superelement:
        """The superelement with the lowest modes only.

        Parameters
        ----------
        modes
            How many; all where there are fewer. A multiple root stays whole.

        Returns
        -------
        Superelement
            As a reduction with so many modes would give it, to rounding.
        """
        return Superelement(self._native.lowest_modes(_checks.whole_number("modes", modes)))

    def __repr__(self) -> str:
        length, mass, time = self.units
        frequencies = self.frequencies
        band = f", {frequencies[0]:.4g} to {frequencies[-1]:.4g} Hz" if len(frequencies) else ""
        return (
            f"<Superelement {self.name!r}: {len(frequencies)} modes{band}, {len(self.rows)} boundary rows of "
            f"{', '.join(self.interfaces) or 'no interface'}, mass {self.mass:.6g} {mass}; {length}, {mass}, {time}>"
        )
