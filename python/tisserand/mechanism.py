"""Mechanisms that a program steps and steers."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tisserand import _native
from tisserand.scene import Scene


class Mechanism(_native.Mechanism):
    """A scene in motion, step by step.

    The lock of the interpreter is given up during steps, so several mechanisms run side by side in threads; calls of one mechanism wait for each
    other.

    Parameters
    ----------
    scene
        A scene, its dictionary, or the path of its file. Its integrator says how steps are made; `step`, `end` and `record` don't matter.
    """

    __slots__ = ("_scene",)
    _scene: Scene

    def __new__(cls, scene: Scene | Mapping[str, Any] | str | PathLike[str]) -> Mechanism:
        described = scene_of(scene)
        made = super().__new__(cls, described._checked())
        made._scene = described
        return made

    def outputs(self, *names: str) -> NDArray[np.float64]:
        """Several outputs one behind the other."""
        return np.concatenate([self.output(name) for name in names])


def scene_of(scene: Scene | Mapping[str, Any] | str | PathLike[str]) -> Scene:
    """A scene from whatever stands for one."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, Mapping):
        return Scene.from_dict(scene)
    return Scene.read(scene)
