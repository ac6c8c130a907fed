"""Scenes: bodies, joints, what drives and loads them, what is recorded."""

from __future__ import annotations

import copy
import json
import shutil
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from os.path import relpath
from pathlib import Path
from typing import Any

import numpy as np

from tisserand import _checks, _native
from tisserand.superelement import Superelement

_GROUPS = ("bodies", "joints", "drives", "springs", "loads", "actuators", "controllers", "outputs", "constants")


class Scene:
    """A mechanism and what is asked of it; the same as a scene file (`docs/scene.md`), made by a program.

    Each method adds a named thing and returns the scene. Keys are those of the file; what is wrong with them is told by :meth:`check`, and by
    whatever uses the scene.

    Parameters
    ----------
    dimension
        2 or 3.
    gravity
        Acceleration, world axes.
    units
        Length, mass and time; superelements in other units are converted.
    keys
        Further keys of the file: `compatibility`, `record`, `analysis` and so on.

    Examples
    --------
    >>> scene = Scene(2, gravity=[0, -9.81])
    >>> scene.rigid("bob", mass=1, inertia=1e-6, points={"pivot": [-0.5, 0]}, position=[0.5, 0])
    >>> scene.revolute("pivot", "ground", "bob/pivot")
    >>> scene.output("angle", joint_coordinate={"joint": "pivot"})
    >>> scene.integrate(step=1e-3, end=1)
    """

    def __init__(
        self,
        dimension: int = 3,
        *,
        gravity: Sequence[float] | None = None,
        units: Sequence[str] | Mapping[str, str] = ("m", "kg", "s"),
        **keys: Any,
    ) -> None:
        self._folder = Path.cwd()
        self._path = "scene"
        self._is_read = False
        self._own: Path | None = None
        self._data: dict[str, Any] = {"dimension": dimension, "units": _checks.units_of(units)}
        if gravity is not None:
            self._data["gravity"] = gravity
        self._data |= keys

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], folder: str | PathLike[str] = ".") -> Scene:
        """A scene from what a file would have; relative paths in it start at `folder`."""
        if not isinstance(data, Mapping):
            raise _native.InputError(f"data: is {type(data).__name__}, expected a dictionary; Scene.read reads a file")
        scene = cls()
        scene._data = copy.deepcopy(dict(data))
        scene._folder = Path(folder).absolute()
        return scene

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Scene:
        """Read and check a scene file."""
        checked = _native.Scene.read(path)
        scene = cls.from_dict(json.loads(checked.to_json()), Path(path).parent)
        scene._path = Path(path).name
        scene._is_read = True
        return scene

    @property
    def path(self) -> Path | None:
        """The file that it was read from, if any."""
        return self._folder / self._path if self._is_read else None

    @property
    def folder(self) -> Path:
        """Where relative paths in it start: what :meth:`from_dict` wants beside :meth:`to_dict`."""
        return self._folder

    def to_dict(self) -> dict[str, Any]:
        """What a file would have."""
        return copy.deepcopy(self._data)

    def write(self, path: str | PathLike[str]) -> None:
        """Write a scene file; relative paths in it are rewritten to start at its folder. Superelements in memory aren't in it: write them first, and
        name their files.
        """
        if self._own is not None:
            raise _native.InputError("the scene has superelements in memory; write them to files and give the bodies their paths")
        data = self.to_dict()
        folder = Path(path).absolute().parent
        for body in [data.get("ground"), *data.get("bodies", {}).values()]:
            for what, key in [(body, "superelement"), *((solid, "file") for solid in _solids(body))]:
                if isinstance(what, dict) and isinstance(what.get(key), str) and not Path(what[key]).is_absolute():
                    what[key] = relpath(self._folder / what[key], folder)
        Path(path).write_text(json.dumps(data, indent=2, default=_plain) + "\n")

    def body(self, name: str, superelement: Superelement | str | PathLike[str], **keys: Any) -> Scene:
        """A flexible body of a superelement, in memory or in a file: `position`, `orientation`, `velocity`, `modes` and so on."""
        if isinstance(superelement, Superelement):
            if self._own is None:
                self._own = Path(tempfile.mkdtemp(prefix="tisserand-"))
                weakref.finalize(self, shutil.rmtree, self._own, ignore_errors=True)
            path = self._own / f"{len(self._data.get('bodies', {}))}.dcb.h5"
            superelement.write(path, overwrite=True)
        else:
            path = Path(fspath(superelement))
        return self.add("bodies", name, {"superelement": str(path), **keys})

    def rigid(
        self,
        name: str,
        *,
        mass: float,
        inertia: Any,
        points: Mapping[str, Any] | None = None,
        center_of_mass: Sequence[float] | None = None,
        **keys: Any,
    ) -> Scene:
        """A rigid body: rotary inertia about its centre of mass, and named points. Without inertia (0, or [0, 0, 0]) it is a point mass."""
        rigid: dict[str, Any] = {"mass": mass, "inertia": inertia, "points": dict(points or {})}
        if center_of_mass is not None:
            rigid["center_of_mass"] = center_of_mass
        return self.add("bodies", name, {"rigid": rigid, **keys})

    def joint(self, name: str, kind: str, **keys: Any) -> Scene:
        """A joint of any kind: `gear`, `distance`, `planar` and so on."""
        return self.add("joints", name, {kind: keys})

    def fixed(self, name: str, a: str, b: str, **keys: Any) -> Scene:
        """Two places that move together. Places are `body/interface`, `body/point` or `ground`."""
        return self.joint(name, "fixed", a=a, b=b, **keys)

    def revolute(self, name: str, a: str, b: str, **keys: Any) -> Scene:
        """A hinge; in space about `axis`."""
        return self.joint(name, "revolute", a=a, b=b, **keys)

    def prismatic(self, name: str, a: str, b: str, **keys: Any) -> Scene:
        """A slide along `axis`."""
        return self.joint(name, "prismatic", a=a, b=b, **keys)

    def spherical(self, name: str, a: str, b: str, **keys: Any) -> Scene:
        """A ball joint."""
        return self.joint(name, "spherical", a=a, b=b, **keys)

    def drive(self, name: str, kind: str, joint: str, **law: Any) -> Scene:
        """A drive of a joint: `angle`, `position` or `speed`, with its function of time (`formula`, `polynomial`, `table`, `input` and so on)."""
        return self.add("drives", name, {kind: {"joint": joint, **law}})

    def spring(self, name: str, kind: str = "spring", **keys: Any) -> Scene:
        """A spring: `spring`, `torsion_spring` or `bushing`."""
        return self.add("springs", name, {kind: keys})

    def load(self, name: str, kind: str, **keys: Any) -> Scene:
        """A load: `force`, `torque` or `part_load`; each component is a number, a function of time, or an input."""
        return self.add("loads", name, {kind: keys})

    def actuator(self, name: str, kind: str, joint: str, **law: Any) -> Scene:
        """An effort on a joint: `torque` or `force` with its function (`formula`, `input`, `controller` and so on), `servo`, `friction` or `end_stop`."""
        return self.add("actuators", name, {kind: {"joint": joint, **law}})

    def controller(self, name: str, formula: str, *, period: float | None = None) -> Scene:
        """A formula of outputs that actuators call by its name; sampled at `period` and held, or continuous."""
        return self.add("controllers", name, {"formula": formula} if period is None else {"formula": formula, "period": period})

    def output(self, name: str, what: str | None = None, **keys: Any) -> Scene:
        """Something to record: `output("energy", "energy")`, `output("tip", position={"at": "rod/tip"})`, or `output("spin", angular_momentum={})`."""
        return self.add("outputs", name, what if what is not None else keys)

    def constant(self, name: str, value: float) -> Scene:
        """A number that formulas call by its name."""
        return self.add("constants", name, value)

    def integrate(self, *, step: float, end: float, method: str = "generalized_alpha", **keys: Any) -> Scene:
        """How the motion is integrated."""
        return self.set(integrator={method: {"step": step, "end": end, **keys}})

    def set(self, **keys: Any) -> Scene:
        """Further keys of the file: `record`, `analysis`, `initial`, `compatibility` and so on."""
        self._data |= keys
        return self

    def add(self, group: str, name: str, what: Any) -> Scene:
        """A named entry of a group of the file, such as `springs`; a name is given once."""
        named = self._data.setdefault(group, {})
        if name in named:
            raise _native.InputError(f"{group}.{name}: is there already; names must differ")
        named[name] = what
        return self

    def check(self) -> Scene:
        """Check all that can be known before superelements are loaded."""
        self._checked()
        return self

    def _checked(self) -> _native.Scene:
        try:
            text = json.dumps(self._data, default=_plain, allow_nan=False)
        except ValueError as error:
            raise _native.InputError("scene: has a number that isn't finite") from error
        return _native.Scene.parse(text, self._folder / self._path)

    def __repr__(self) -> str:
        counts = [f"{len(self._data[group])} {group}" for group in _GROUPS if self._data.get(group)]
        return f"<Scene in {self._data.get('dimension')}-D: {', '.join(counts) or 'empty'}>"


def _solids(body: Any) -> list[Any]:
    geometry = body.get("geometry") if isinstance(body, dict) else None
    return geometry if isinstance(geometry, list) else []


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as JSON has them."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise _native.InputError(f"scene: {value!r} is neither text, number, list nor mapping")


def scene_of(scene: Scene | Mapping[str, Any] | str | PathLike[str]) -> Scene:
    """A scene from whatever stands for one."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, Mapping):
        return Scene.from_dict(scene)
    return Scene.read(scene)
