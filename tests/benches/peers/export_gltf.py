"""pygltflib reads what `reduce export --to gltf` wrote: one shape for each mode, places in metres as the superelement has them.

    python3 export_gltf.py PART.glb PART.dcb.h5      pygltflib numpy h5py

Exit status 1 where a limit is broken.
"""
import json
import sys

import h5py
import numpy as np
from pygltflib import GLTF2

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
SINGLE = 1e-6                                                                    # glTF has single precision


def array(scene, number):
    accessor = scene.accessors[number]
    view = scene.bufferViews[accessor.bufferView]
    start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
    return np.frombuffer(scene.binary_blob(), "<f4", 3 * accessor.count, start).reshape(-1, 3)


def main():
    scene = GLTF2().load(sys.argv[1])
    with h5py.File(sys.argv[2]) as f:
        points = f["mesh/points"][:] * METRES[json.loads(f.attrs["units"])["length"]]
        modes = len(f["modes/eigenvalues"])
        origin = f["frame/origin"][:]
    primitive = scene.meshes[0].primitives[0]
    places = array(scene, primitive.attributes.POSITION)
    shapes = [array(scene, target["POSITION"]) for target in primitive.targets]
    off = min(max(np.linalg.norm(points - shift - place, axis=1).min() for place in places) for shift in (0 * origin, origin))
    size = np.linalg.norm(np.ptp(points, axis=0))
    print(f"pygltflib reads {sys.argv[1]}: {len(places)} vertices, {len(shapes)} shapes of {modes} modes, {len(scene.animations)} animations; places off by {off / size:.1e} of the size")
    moving = all(np.abs(shape).max() > 0 for shape in shapes)
    raise SystemExit(int(not (off <= SINGLE * size and len(shapes) == modes == len(scene.animations) and moving)))


if __name__ == "__main__":
    main()
