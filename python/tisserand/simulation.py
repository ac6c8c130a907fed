"""Whole runs."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Callable, Mapping
from os import PathLike
from os.path import relpath
from pathlib import Path
from typing import Any, Literal

from tisserand import _checks, _native
from tisserand.results import Results
from tisserand.scene import Scene, scene_of


def simulate(
    scene: Scene | Mapping[str, Any] | str | PathLike[str],
    output: str | PathLike[str] | None = None,
    *,
    overwrite: bool = False,
    model: Literal["needed", "everything"] = "needed",
    tolerance: float = 1e-3,
    fields_in: str | PathLike[str] | None = None,
    progress: Callable[[float, float], object] | None = None,
    note: Callable[[float, str], object] | None = None,
) -> Results:
    """Run a scene, as the program `simulate` does.

    Parameters
    ----------
    scene
        A scene, its dictionary, or the path of its file.
    output
        File of the results, HDF5 (`docs/results.md`); without it they are in a temporary file as long as the results are used.
    overwrite
        Replace a file that exists; by default it is refused.
    model
        What of the superelements is carried: `"needed"`, what this scene needs, by default, or `"everything"`.
    tolerance
        Relative error of the parts' responses that leaving out the rest may make, between 0 and 1, 1e-3 by default; `note` is told what it makes.
    fields_in
        Folder in which the scene may write its `fields`, beside its own folder and that of the results.
    progress
        Called now and then with the time reached and the end, in the scene's unit of time.
    note
        Called with time (the scene's unit) and text of what is worth telling.

    Returns
    -------
    Results
        What was recorded, read when it is asked for. If a function that is called raises, or the user presses Ctrl-C, the run ends with that
        exception; the file has what was reached.
    """
    described = scene_of(scene)
    carried = None if _checks.one_of("model", model, ("needed", "everything")) == "everything" else _checks.share("tolerance", tolerance)
    _checks.function("progress", progress)
    _checks.function("note", note)
    folder = tempfile.mkdtemp(prefix="tisserand-") if output is None else None
    path = Path(folder) / "results.h5" if folder is not None else Path(output or "")

    def told(time: float, end: float | None, message: str | None) -> None:
        if message is not None and note is not None:
            note(time, message)
        if end is not None and progress is not None:
            progress(time, end)

    is_told = progress is not None or note is not None
    try:
        scene_file = None if described.path is None else relpath(described.path, path.parent.absolute())
        _native.simulate(described._checked(), path, overwrite, carried, scene_file, fields_in, told if is_told else None)
        results = Results(path)
    except BaseException:
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)
        raise
    if folder is not None:
        weakref.finalize(results, shutil.rmtree, folder, ignore_errors=True)
    return results
