"""Pictures in pyvista: modes of superelements, and the fields that a run has written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

import tisserand.meshio
from tisserand import _native
from tisserand.superelement import Superelement

# Of the size of a part, that the largest displacement of a mode is drawn with.
_SHARE = 0.1


def mode(part: Superelement, number: int) -> Any:
    """A `pyvista.UnstructuredGrid` of a superelement, displaced in a mode counted from 0; the largest displacement is a tenth of the part's size.

    Its points are the displaced ones; the displacements themselves are the point data `displacement`.

    Parameters
    ----------
    part
        A superelement with its mesh and its nodal fields.
    number
        The mode, counted from 0.

    Returns
    -------
    pyvista.UnstructuredGrid
        The displaced part. Points and displacements, (n, 3), are in the part's own coordinates and its unit of length.
    """
    import pyvista

    grid = pyvista.from_meshio(tisserand.meshio.mesh(part))
    shape = part.shape(number)
    largest = float(np.linalg.norm(shape, axis=1).max())
    scale = _SHARE * grid.length / largest if largest > 0 else 0.0
    grid.points = np.asarray(grid.points) + scale * shape
    grid.point_data["displacement"] = scale * shape
    return grid


def fields(series: str | PathLike[str]) -> Iterator[tuple[float, Any]]:
    """Time and `pyvista.UnstructuredGrid` of each picture of a series `BODY.pvd` that a run has written (`fields` of a scene).

    Parameters
    ----------
    series
        The file `BODY.pvd`.

    Yields
    ------
    float
        Time, in the scene's unit of time.
    pyvista.UnstructuredGrid
        The body at this time.
    """
    import pyvista

    path = Path(series)
    if not path.is_file():
        raise _native.InputError(f"{path}: is no file; a scene writes such series with its key `fields`")
    reader = pyvista.PVDReader(path)
    for time in reader.time_values:
        reader.set_active_time_value(time)
        yield time, reader.read()[0]


def animate(series: Mapping[str, str | PathLike[str]], target: str | PathLike[str], *, frames_per_second: int = 25, scalars: str | None = None) -> int:
    """Write a moving picture (`.gif`) of several bodies' series, and say the number of its frames.

    Parameters
    ----------
    series
        The file `BODY.pvd` of each body, by name. A frame is made of the first pictures of all of them, then of the second ones and so on.
    target
        The file of the picture.
    frames_per_second
        Frames shown in a second; 25 by default, whatever times lie between them.
    scalars
        Name of the point data that colours the bodies, by its magnitude; pyvista's active one by default.

    Returns
    -------
    int
        Number of frames: that of the shortest series.

    Raises
    ------
    InputError
        A file isn't there, or a series has no picture.
    """
    import pyvista

    bodies = [list(fields(path)) for path in series.values()]
    count = min(map(len, bodies))
    if count == 0:
        raise _native.InputError("the series have no picture in common")
    everything: Any = pyvista.merge([grid for body in bodies for _, grid in body])
    plotter: Any = pyvista.Plotter(off_screen=True)
    plotter.open_gif(str(target), fps=frames_per_second)
    for frame in range(count):
        plotter.clear()
        for body in bodies:
            time, grid = body[frame]
            plotter.add_mesh(grid, scalars=scalars, show_scalar_bar=False)
        plotter.add_text(f"t = {time:.4g}", font_size=10)
        plotter.reset_camera(bounds=everything.bounds)
        plotter.write_frame()
    plotter.close()
    return count

