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
    whatever uses the scene. All numbers are in the scene's units of length, mass and time: a force is in mass * length / time², N in SI. Angles are
    in rad.

    Parameters
    ----------
    dimension
        2 for a planar scene, which lies in x and y and turns about z, or 3, the default.
    gravity
        Acceleration of free fall, (2) or (3), length/time², world axes; none by default.
    units
        Names of the units of length, mass and time, in this order or by these words; metres, kilograms and seconds by default. Superelements must
        have the same.
    **keys
        Further keys of the file: `ground`, `record`, `fields`, `compatibility`, `analysis`, `initial` and so on.

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
        """A scene from what a file would have; relative paths in it start at `folder`.

        Parameters
        ----------
        data
            The keys of a scene file with their values, as :meth:`to_dict` gives them. They are copied.
        folder
            Folder where relative paths start; the current one by default.

        Returns
        -------
        Scene
            A new scene; :meth:`check` says what is wrong with it.
        """
        if not isinstance(data, Mapping):
            raise _native.InputError(f"data: is {type(data).__name__}, expected a dictionary; Scene.read reads a file")
        scene = cls()
        scene._data = copy.deepcopy(dict(data))
        scene._folder = Path(folder).absolute()
        return scene

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Scene:
        """Read and check a scene file.

        Parameters
        ----------
        path
            The file, JSON. Relative paths in it start at its folder.

        Returns
        -------
        Scene
            A new scene.

        Raises
        ------
        InputError
            The file can't be read, or something in it is wrong.
        """
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
        """Folder where relative paths in it start: what :meth:`from_dict` wants beside :meth:`to_dict`."""
        return self._folder

    def to_dict(self) -> dict[str, Any]:
        """What a file would have.

        Returns
        -------
        dict
            The keys of a scene file with their values, a copy. Arrays that the scene was given are still arrays. A superelement in memory is there by
            the path of its temporary file.
        """
        return copy.deepcopy(self._data)

    def write(self, path: str | PathLike[str]) -> None:
        """Write a scene file; relative paths in it are rewritten to start at its folder.

        Superelements in memory aren't in it: write them first, and name their files.

        Parameters
        ----------
        path
            The file. One that is there already is replaced.

        Raises
        ------
        InputError
            The scene has superelements in memory.
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
        """A flexible body of a superelement, in memory or in a file: `position`, `orientation`, `velocity`, `modes` and so on.

        Parameters
        ----------
        name
            Name of the body. Its places are `NAME/INTERFACE`.
        superelement
            A superelement in memory, which is written to a temporary file, or the path of a file `.dcb.h5`. A relative path starts at the scene's
            folder.
        **keys
            State at time zero: `position` (length), `orientation` (an angle in rad, or a unit quaternion `[w, x, y, z]`), `velocity` (length/time)
            and `angular_velocity` (rad/time), all zero where absent. Position and velocity are those of the origin of the part's own coordinates, in
            world axes. Further `modes`, `damping`, `inertia_change`, `geometric_stiffening` and `geometry`.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
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
        """A rigid body: rotary inertia about its centre of mass, and named points. Without inertia (0, or [0, 0, 0]) it is a point mass.

        Parameters
        ----------
        name
            Name of the body. Its places are `NAME/POINT`.
        mass
            Mass, positive.
        inertia
            Rotary inertia about the centre of mass, in the body's own axes, mass * length². A number in a planar scene; three principal moments, (3),
            or a symmetric matrix, (3, 3), in a spatial one.
        points
            Places for joints, springs, loads and outputs, by name. Each is a list of coordinates, (2) or (3), length, or a mapping with `position`
            and `orientation`. They are in the body's own coordinates. None by default.
        center_of_mass
            Centre of mass in the body's own coordinates, (2) or (3), length; the origin by default.
        **keys
            State at time zero, as in :meth:`body`: `position`, `orientation`, `velocity` and `angular_velocity`. Further `geometry`.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        rigid: dict[str, Any] = {"mass": mass, "inertia": inertia, "points": dict(points or {})}
        if center_of_mass is not None:
            rigid["center_of_mass"] = center_of_mass
        return self.add("bodies", name, {"rigid": rigid, **keys})

    def joint(self, name: str, kind: str, **keys: Any) -> Scene:
        """A joint of any kind: `gear`, `distance`, `planar` and so on.

        Parameters
        ----------
        name
            Name of the joint.
        kind
            `"fixed"`, `"revolute"`, `"prismatic"`, `"cylindrical"`, `"planar"`, `"universal"`, `"spherical"`, `"point_on_line"`, `"distance"`,
            `"gear"` or `"rack"`. The kinds cylindrical, planar, universal and spherical are for spatial scenes only.
        **keys
            `a` and `b`, the two places, for all kinds but the last two. Beside them `orientation` for fixed; `axis`, `axis_b` and `orientation` for
            revolute, cylindrical, planar and universal; `axis` and `orientation` for prismatic and point_on_line; `length` (length) for distance. For
            a gear `first`, `second` (names of joints) and `ratio`. For a rack `rotation`, `translation` (names of joints) and `radius` (length).

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.add("joints", name, {kind: keys})

    def fixed(self, name: str, a: str, b: str, **keys: Any) -> Scene:
        """Two places that move together. Places are `body/interface`, `body/point`, `ground` or `ground/point`.

        Parameters
        ----------
        name
            Name of the joint.
        a, b
            The two places. A reaction is the force on the body of `a`.
        **keys
            `orientation`: with `"body"` the joint takes the rotation of the body's frame where an interface has no rotation rows.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.joint(name, "fixed", a=a, b=b, **keys)

    def revolute(self, name: str, a: str, b: str, **keys: Any) -> Scene:
        """A hinge; in space about `axis`.

        Parameters
        ----------
        name
            Name of the joint.
        a, b
            The two places, which coincide. The angle of the joint is that from `a` to `b`, in rad.
        **keys
            `axis`, `axis_b` and `orientation`. `axis` is a direction, (3), in the axes of `a`, and needed in space. `axis_b` is the same direction in
            the axes of `b`; without it the axis lies in `b` as the initial placement draws it. A planar scene has neither. `orientation` is as in
            :meth:`fixed`.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.joint(name, "revolute", a=a, b=b, **keys)

    def prismatic(self, name: str, a: str, b: str, **keys: Any) -> Scene:
        """A slide along `axis`, without rotation.

        Parameters
        ----------
        name
            Name of the joint.
        a, b
            The two places. The coordinate of the joint is the translation of `b` against `a`, a length; it is zero as placed at the start.
        **keys
            `axis` and `orientation`. `axis` is needed: a direction, (2) or (3), in the axes of `a`. `orientation` is as in :meth:`fixed`.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.joint(name, "prismatic", a=a, b=b, **keys)

    def spherical(self, name: str, a: str, b: str, **keys: Any) -> Scene:
        """A ball joint, for spatial scenes; in a planar one :meth:`revolute` is the same.

        Parameters
        ----------
        name
            Name of the joint.
        a, b
            The two places, which coincide.
        **keys
            This kind has no further keys.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.joint(name, "spherical", a=a, b=b, **keys)

    def drive(self, name: str, kind: str, joint: str, **law: Any) -> Scene:
        """A drive of a joint: `angle`, `position` or `speed`, with its function of time (`formula`, `polynomial`, `table`, `input` and so on).

        Parameters
        ----------
        name
            Name of the drive.
        kind
            `"angle"` (rad) of a revolute or cylindrical joint, `"position"` (length) of a prismatic, cylindrical or distance joint, or `"speed"`
            (rad/time or length/time) of any of these but a cylindrical one.
        joint
            Name of the joint.
        **law
            The function of time, exactly one of `constant`, `polynomial`, `harmonic`, `table`, `smooth_step`, `trapezoid`, `chirp`, `pulse`,
            `formula` and `input`. A speed can't be an `input`.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.add("drives", name, {kind: {"joint": joint, **law}})

    def spring(self, name: str, kind: str = "spring", **keys: Any) -> Scene:
        """A spring with a damper: `spring`, `torsion_spring` or `bushing`.

        Parameters
        ----------
        name
            Name of the spring.
        kind
            `"spring"`, the default, along the line between two places; `"torsion_spring"` about the axis of a revolute or cylindrical joint;
            `"bushing"` between two places in every direction of the axes of the first one.
        **keys
            For a spring `a`, `b`, `stiffness` (force/length), `damping` (force * time/length) and `free_length` (length). For a torsion spring
            `joint`, `stiffness` (moment/rad), `damping` (moment * time/rad) and `free_angle` (rad). What is free is as placed at the start where it
            is absent. For a bushing `a`, `b`, `translation`, `rotation`, `translation_damping` and `rotation_damping`, lists with one entry for each
            direction. A stiffness or damping is a number or a table.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.add("springs", name, {kind: keys})

    def load(self, name: str, kind: str, **keys: Any) -> Scene:
        """A load: `force`, `torque` or `part_load`; each component is a number, a function of time, or an input.

        Parameters
        ----------
        name
            Name of the load. :meth:`Mechanism.set_input` calls an input of it so too, or `NAME/INDEX` where several components are inputs.
        kind
            `"force"` (mass * length / time², N in SI), `"torque"` (mass * length² / time², N*m in SI) or `"part_load"`, a load on the inside of a
            superelement.
        **keys
            For a force or torque `at` (a place), `components` and `axes`, which are `"world"`, the default, or `"follower"`. A force has 2 (planar)
            or 3 components, a torque 1 or 3. For a part_load `body`, `load` (its name in the superelement) and `factor` (without unit).

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.add("loads", name, {kind: keys})

    def actuator(self, name: str, kind: str, joint: str, **law: Any) -> Scene:
        """An effort on a joint: `torque` or `force` with its function (`formula`, `controller` and so on), `servo`, `friction` or `end_stop`.

        Parameters
        ----------
        name
            Name of the actuator.
        kind
            `"torque"` on the angle of a revolute or cylindrical joint, `"force"` on the coordinate of a prismatic, cylindrical or distance joint, or
            `"servo"`, `"friction"` or `"end_stop"` on any of these.
        joint
            Name of the joint. A positive effort makes its coordinate grow.
        **law
            For a torque (N*m in SI) or force (N in SI) exactly one function of time as in :meth:`drive`, an `input`, or `controller`, the name of
            one. For a servo `target`, `proportional`, `derivative`, `integral`, `limit`, `saturation`, `tracking_time` and `sample`. For friction
            `coulomb`, `static`, `stribeck_rate`, `viscous` and `regularization`. For an end_stop `lower`, `upper`, `stiffness`, `damping` and
            `onset`. These three also take `coordinate`, `"angle"` or `"position"`, which a cylindrical joint needs.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.add("actuators", name, {kind: {"joint": joint, **law}})

    def controller(self, name: str, formula: str, *, period: float | None = None) -> Scene:
        """A formula of outputs that actuators call by its name; sampled at `period` and held, or continuous.

        Parameters
        ----------
        name
            Name of the controller. The actuators `torque` and `force` take it as `controller=NAME`.
        formula
            The effort, in the unit of the actuators that use it. It knows the time `t`, the constants and the outputs of the scene by their names,
            and components of outputs as `tip.x`.
        period
            Interval at which the effort is computed and held, time. By default the effort always follows; then the formula may have outputs
            `joint_coordinate` and `joint_rate` only.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.add("controllers", name, {"formula": formula} if period is None else {"formula": formula, "period": period})

    def output(self, name: str, what: str | None = None, **keys: Any) -> Scene:
        """Something to record: `output("energy", "energy")`, `output("tip", position={"at": "rod/tip"})`, or `output("spin", angular_momentum={})`.

        Parameters
        ----------
        name
            Name of the output. Results, mechanisms and controllers call it so.
        what
            `"energy"`, the one kind without keys. Leave it out for all others.
        **keys
            One kind of output with its keys, such as `displacement={"at": "rod/tip"}`, `joint_coordinate={"joint": "axle"}` or
            `reaction={"joint": "axle", "axes": "first"}`. `docs/scene.md` lists all kinds.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        if (what is None) == (not keys):
            raise _native.InputError(f'output: {name!r} wants one of the two: "energy", or a kind with its keys, such as position={{"at": "rod/tip"}}')
        return self.add("outputs", name, what if what is not None else keys)

    def constant(self, name: str, value: float) -> Scene:
        """A number that formulas call by its name.

        Parameters
        ----------
        name
            Name of the constant.
        value
            The number, in whatever unit the formulas want.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.add("constants", name, value)

    def integrate(self, *, step: float, end: float, method: str = "generalized_alpha", **keys: Any) -> Scene:
        """How the motion is integrated.

        Parameters
        ----------
        step
            Length of a step, time.
        end
            Time at which the run ends.
        method
            `"generalized_alpha"`, the default, or `"hht"`.
        **keys
            `rho_infinity` (generalized_alpha) or `alpha` (hht), `formulation`, `tolerance`, `max_iterations` and `adaptive`.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        return self.set(integrator={method: {"step": step, "end": end, **keys}})

    def set(self, **keys: Any) -> Scene:
        """Further keys of the file: `record`, `analysis`, `initial`, `compatibility` and so on.

        Parameters
        ----------
        **keys
            Keys of the scene with their values. A key that is there already gets the new value.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.
        """
        self._data |= keys
        return self

    def add(self, group: str, name: str, what: Any) -> Scene:
        """A named entry of a group of the file, such as `springs`; a name is given once.

        Parameters
        ----------
        group
            `"bodies"`, `"joints"`, `"drives"`, `"springs"`, `"loads"`, `"actuators"`, `"controllers"`, `"outputs"` or `"constants"`.
        name
            Name of the entry.
        what
            What the file would have there.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.

        Raises
        ------
        InputError
            The group has an entry of this name.
        """
        named = self._data.setdefault(group, {})
        if name in named:
            raise _native.InputError(f"{group}.{name}: is there already; names must differ")
        named[name] = what
        return self

    def check(self) -> Scene:
        """Check all that can be known before superelements are loaded.

        Returns
        -------
        Scene
            This scene, so that calls can be chained.

        Raises
        ------
        InputError
            Something is wrong; the text names the place in the scene.
        """
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
