"""Linear systems of mechanisms: A, B, C and D about a state."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tisserand import _checks, _native
from tisserand.scene import Scene, scene_of

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
class Truncation:
    """What a balanced truncation has left out. :attr:`LinearSystem.truncation` gives it."""

    full_order: int
    """Number of states before."""
    kept_apart: int
    """Number of poles that don't decay, or hardly; they are kept, exactly."""
    hankel: NDArray[np.float64]
    """Hankel singular values of the rest, (full_order - kept_apart), falling, as parts of the largest, inputs and outputs scaled."""
    bound: float
    """Twice the sum of the Hankel singular values left out, without unit."""
    bounds: NDArray[np.float64]
    """At any frequency the error of an output by an input is at most this, (n_y, n_u), unit of the output by that of the input."""


class LinearSystem:
    """`x' = A x + B (u - u0)`, `y = y0 + C x + D (u - u0)`: x is the deviation from the motion at the operating point.

    Numbers are in the units of the scene. Made by :func:`linearize` and :meth:`Mechanism.linearize`. It has n states, n_u inputs and n_y outputs.

    Attributes
    ----------
    A, B, C, D
        The matrices, (n, n), (n, n_u), (n_y, n) and (n_y, n_u), read-only.
    state_names, state_units
        Names and units of the states, n each; `docs/linear-systems.md` says what they are.
    input_names, input_units
        Names and units of the inputs, n_u each.
    output_names, output_units
        Names and units of the outputs, n_y each; components are as `tip.x`.
    u0, y0
        Inputs, (n_u), and outputs, (n_y), at the operating point, in their units.
    poles
        Eigenvalues of A, (n), complex, by increasing size: the real part in 1/time, the imaginary part in rad/time.
    """

    def __init__(self, system: _native.LinearSystem) -> None:
        self._system = system
        self.A, self.B, self.C, self.D = (system.matrix(name) for name in "ABCD")
        self.state_names, self.state_units, _ = _columns(system.states)
        self.input_names, self.input_units, self.u0 = _columns(system.inputs)
        self.output_names, self.output_units, self.y0 = _columns(system.outputs)
        self.poles: NDArray[np.complex128] = np.array([complex(*pole) for pole in system.poles], dtype=complex)

    @property
    def units(self) -> tuple[str, str, str]:
        """Names of the scene's units of length, mass and time."""
        return self._system.units

    @property
    def time(self) -> float:
        """Time of the operating point, in the scene's unit of time."""
        return self._system.time

    @property
    def is_equilibrium(self) -> bool:
        """Whether the mechanism rests there."""
        return self._system.is_equilibrium

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Frequencies of the poles, (n), in cycles by the scene's unit of time: Hz where that is the second."""
        return np.asarray(np.abs(self.poles.imag) / (2 * np.pi))

    @property
    def damping_ratios(self) -> NDArray[np.float64]:
        """Damping ratios of the poles, (n), -Re(s)/|s|; zero for s = 0."""
        size = np.abs(self.poles)
        return np.asarray(np.divide(-self.poles.real, size, out=np.zeros(len(size)), where=size > 0))

    @property
    def truncation(self) -> Truncation | None:
        """What was left out of a larger system, if anything."""
        found = self._system.truncation
        if found is None:
            return None
        full_order, kept_apart, hankel, bound, bounds = found
        return Truncation(full_order, kept_apart, np.array(hankel), bound, np.array(bounds))

    def to_control(self) -> control.StateSpace:
        """A system of the package `control`, of deviations: its inputs are u - u0, its outputs y - y0. Dots in names become underscores.

        Returns
        -------
        control.StateSpace
            Continuous in time, with the names of states, inputs and outputs. Numbers are in the units of the scene.
        """
        import control

        names = {
            key: [name.replace(".", "_") for name in names]
            for key, names in (("states", self.state_names), ("inputs", self.input_names), ("outputs", self.output_names))
        }
        return control.ss(self.A, self.B, self.C, self.D, **names)

    def write(self, path: str | PathLike[str], *, overwrite: bool = False) -> None:
        """Write it; the ending says what: `.h5`, `.npz` or `.mat`.

        Parameters
        ----------
        path
            The file: HDF5, NumPy or MATLAB, as it ends. `docs/linear-systems.md` says what stands in it.
        overwrite
            Replace one that exists; by default it is refused.
        """
        self._system.write(path, overwrite)

    def __repr__(self) -> str:
        return f"<LinearSystem: {len(self.A)} states, {len(self.u0)} inputs, {len(self.y0)} outputs>"


def linearize(
    scene: Scene | Mapping[str, Any] | str | PathLike[str],
    at: str | float = "initial",
    *,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    order: int | None = None,
    note: Callable[[float, str], object] | None = None,
) -> LinearSystem:
    """The linear system of a scene, as `simulate linearize` writes it.

    Parameters
    ----------
    scene
        A scene, its dictionary, or the path of its file.
    at
        `"initial"`, the default: the start, made consistent. `"static"`: a stable rest near the start. Or a time that the motion reaches, in the
        scene's unit of time.
    inputs
        Names of loads, components of loads as `NAME/INDEX`, actuators and drives; those that are declared as `input` where none is named, or all if
        none is declared. The input of a drive is the acceleration of its coordinate.
    outputs
        Outputs, or whatever else a run records, as `reactions/JOINT`; the scene's outputs where none is named.
    order
        Number of states, by balanced truncation; all by default.
    note
        Called with time (the scene's unit) and text of what is worth telling.

    Returns
    -------
    LinearSystem
        A, B, C and D with names, units, poles and operating point, in the units of the scene.

    Raises
    ------
    InputError
        Something in the scene or a name is wrong, or `order` is below the number of poles that must be kept.
    """

    def told(time: float, _: float | None, message: str | None) -> None:
        if message is not None and note is not None:
            note(time, message)

    checked = scene_of(scene)._checked()
    _checks.function("note", note)
    asked = (_checks.names("inputs", inputs, '["motor"]'), _checks.names("outputs", outputs, '["angle"]'), _checks.optional_whole_number("order", order, 1))
    return LinearSystem(_native.linearize(checked, at, *asked, told if note is not None else None))


def _columns(variables: list[tuple[str, str, float]]) -> tuple[list[str], list[str], NDArray[np.float64]]:
    return [name for name, _, _ in variables], [unit for _, unit, _ in variables], np.array([at for _, _, at in variables])
