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
    """What a balanced truncation has left out."""

    full_order: int
    """States before."""
    kept_apart: int
    """Poles that don't decay; they are kept, exactly."""
    hankel: NDArray[np.float64]
    """Hankel singular values of the rest, as parts of the largest, inputs and outputs scaled."""
    bound: float
    """Twice the sum of those left out."""
    bounds: NDArray[np.float64]
    """At any frequency the error of an output by an input is at most this, in their units, (outputs, inputs)."""


class LinearSystem:
    """`x' = A x + B (u - u0)`, `y = y0 + C x + D (u - u0)`: x is the deviation from the motion at the operating point.

    Numbers are in the units of the scene.
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
        """Length, mass and time."""
        return self._system.units

    @property
    def time(self) -> float:
        """Time of the operating point."""
        return self._system.time

    @property
    def is_equilibrium(self) -> bool:
        """Whether the mechanism rests there."""
        return self._system.is_equilibrium

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Of the poles, in cycles by time."""
        return np.asarray(np.abs(self.poles.imag) / (2 * np.pi))

    @property
    def damping_ratios(self) -> NDArray[np.float64]:
        """Of the poles, -Re(s)/|s|; zero for s = 0."""
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
        """A system of the package `control`, of deviations: its inputs are u - u0, its outputs y - y0. Dots in names become underscores."""
        import control

        names = {
            key: [name.replace(".", "_") for name in names]
            for key, names in (("states", self.state_names), ("inputs", self.input_names), ("outputs", self.output_names))
        }
        return control.ss(self.A, self.B, self.C, self.D, **names)

    def write(self, path: str | PathLike[str], *, overwrite: bool = False) -> None:
        """Write it; the ending says what: `.h5`, `.npz` or `.mat`."""
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
        `"initial"`, `"static"` for a stable rest near the start, or a time that the motion reaches.
    inputs
        Loads, components of loads as `NAME/INDEX`, and drives; those that are declared as `input` where none is named, or all if none is declared.
    outputs
        Outputs, or whatever else a run records, as `reactions/JOINT`; the scene's outputs where none is named.
    order
        Number of states, by balanced truncation.
    note
        Called with time and text of what is worth telling.
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
