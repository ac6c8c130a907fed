"""meshio and pyvista read the fields that `simulate` wrote: same places and displacements, all times of the collection.

    python3 read_fields.py FOLDER BODY      numpy meshio pyvista

Exit status 1 where they differ.
"""
import pathlib
import sys

import meshio
import numpy as np
import pyvista


def main():
    folder, body = pathlib.Path(sys.argv[1]), sys.argv[2]
    files = sorted(folder.glob(f"{body}_*.vtu"))
    worst = 0.0
    for file in files:
        ours, theirs = meshio.read(file), pyvista.read(file)
        worst = max(worst, np.abs(ours.points - theirs.points).max(), np.abs(ours.point_data["displacement"] - theirs["displacement"]).max())
    times = pyvista.get_reader(folder / f"{body}.pvd").time_values
    print(f"meshio and pyvista read {len(files)} files, {len(times)} times, and differ by {worst:.1e}")
    raise SystemExit(int(worst > 0.0 or len(times) != len(files) or not files))


if __name__ == "__main__":
    main()
