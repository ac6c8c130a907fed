"""Mechanisms that a program steps and steers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tisserand import _checks, _native
from tisserand.linear import LinearSystem
from tisserand.scene import Scene, scene_of

if TYPE_CHECKING:
    from typing_extensions import Self


class Mechanism(_native.Mechanism):
    """A scene in motion, step by step.

    The lock of the interpreter is given up during steps, so several mechanisms run side by side in threads; calls of one mechanism wait for each
    other.

    Parameters
    ----------
    scene
        A scene, its dictionary, or the path of its file. Its integrator says how steps are made. Its `step`, `end` and `record` don't matter, but a
        drive of a speed by a formula or a chirp is known until `end` only.
    """

    _scene: Scene
    history: History
    """What :meth:`run` has recorded last, also where it failed."""

    def __new__(cls, scene: Scene | Mapping[str, Any] | str | PathLike[str]) -> Self:
        described = scene_of(scene)
        made = super().__new__(cls, described._checked())
        # Superelements in memory live as long as their scene.
        made._scene = described
        made.history = History([])
        return made

    def run(
        self,
        duration: float,
        step: float,
        *,
        control: Callable[[float, Mechanism], Mapping[str, float] | None] | None = None,
        every: int = 1,
        record: Sequence[str] = (),
    ) -> History:
        """Make steps of one length, with a function in the loop.

        Parameters
        ----------
        duration, step
            How long, and the length of a step, both in the scene's unit of time; the last one ends at the duration, or up to half a step from it.
        control
            Called with the time and this mechanism before the first step and after every `every`-th. It returns inputs by name, or `None` for no new
            ones; they are held until it is called again. They act in full from that time on, as those of a controller in the scene that samples so.
            Held so, an input comes half the time between calls late on average: a loop of stiffness k loses k h / 2 of its damping, h being the time
            between calls.
        every
            Steps between two calls of `control`; 1 by default.
        record
            Names of the outputs to record, before the first step and after each; none by default.

        Returns
        -------
        History
            Times and outputs, in the scene's units. If `control` raises, or a step fails, what was recorded until then is :attr:`history`.
        """
        _checks.whole_number("every", every, 1)
        _checks.function("control", control)
        count = round(_checks.positive("duration", duration) / _checks.positive("step", step))
        history = self.history = History(_checks.names("record", record, '["angle"]'))
        history._add(self)
        for number in range(count):
            if control is not None and number % every == 0:
                inputs = control(self.time, self)
                if inputs is not None and not isinstance(inputs, Mapping):
                    raise _native.InputError(f'control: returned {inputs!r}, expected inputs by name, such as {{"motor": 0.5}}, or None')
                for name, value in (inputs or {}).items():
                    self.set_input(name, value)
            self.step(step)
            history._add(self)
        return history

    def linearize(self, *, inputs: Sequence[str] = (), outputs: Sequence[str] = (), order: int | None = None) -> LinearSystem:
        """The linear system about the present state, with the inputs as they are now; parameters as of :func:`tisserand.linearize`.

        Parameters
        ----------
        inputs
            Names of loads, components of loads as `NAME/INDEX`, actuators and drives; those that are declared as `input` where none is named, or all
            if none is declared.
        outputs
            Outputs, or whatever else a run records, as `reactions/JOINT`; the scene's outputs where none is named.
        order
            Number of states, by balanced truncation; all by default.

        Returns
        -------
        LinearSystem
            A, B, C and D with names, units, poles and operating point, in the units of the scene.
        """
        asked = (_checks.names("inputs", inputs, '["motor"]'), _checks.names("outputs", outputs, '["angle"]'))
        return LinearSystem(self.linear_system(*asked, _checks.optional_whole_number("order", order, 1)))

    def outputs(self, *names: str) -> NDArray[np.float64]:
        """Several outputs one behind the other.

        Parameters
        ----------
        *names
            Names of outputs, or whatever else a run records, as `reactions/JOINT`.

        Returns
        -------
        ndarray
            Their numbers at the present time, (n), in the order of the names, each in the scene's units. An output with several columns has several
            numbers.
        """
        return np.concatenate([np.zeros(0), *(self.output(name) for name in names)])


class History:
    """Outputs that :meth:`Mechanism.run` has recorded, which makes it. `history["angle"]` is an output over time."""

    def __init__(self, names: list[str]) -> None:
        self._time: list[float] = []
        self._values: dict[str, list[NDArray[np.float64]]] = {name: [] for name in names}

    def _add(self, motion: Mechanism) -> None:
        self._time.append(motion.time)
        for name, values in self._values.items():
            values.append(motion.output(name))

    @property
    def time(self) -> NDArray[np.float64]:
        """Times, (steps + 1), in the scene's unit of time."""
        return np.array(self._time)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """An output over time: (steps + 1), or (steps + 1, columns) where it has several.

        Parameters
        ----------
        name
            Name of an output that was recorded.

        Returns
        -------
        ndarray
            Its values at the times of :attr:`time`, in the scene's units.
        """
        if name not in self._values:
            raise _native.InputError(f"{name!r} wasn't recorded; recorded are {', '.join(self._values) or 'none'}")
        values = np.array(self._values[name])
        return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values

    def __len__(self) -> int:
        return len(self._time)
