"""Expected numbers of ../nastran/ugly.bdf from pyNastran: python nastran_ugly.py (pyNastran 1.4.1, numpy < 2) writes ../nastran/ugly.json.

Left out for pyNastran are cards that it refuses or reads otherwise: cards listed again, SET3, a card behind ENDDATA, GRDSET: a zero overrides it, which pyNastran takes for a blank; grid 3 alone has a blank there.
The axes of displacements are central differences of pyNastran's own way from local to basic coordinates.
"""
import json, os, tempfile
import numpy as np
from pyNastran.bdf.bdf import BDF

HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = os.path.join(HERE, "..", "nastran", "ugly.bdf")
lines = open(SOURCE).read().split("ENDDATA")[0].split("\n")
start = lines.index("BEGIN BULK") + 1
bulk, seen, skipping = [], set(), False
for line in lines[start:]:
    head = line.split(",")[0][:8].strip().upper()
    if head and head[0] not in "+*$":
        key = line.split("$")[0].rstrip()
        skipping = key in seen or head in ("SET3", "GRDSET")
        seen.add(key)
    if not skipping:
        bulk.append(line)
with tempfile.NamedTemporaryFile("w", suffix=".bdf", delete=False) as file:
    file.write("\n".join(bulk) + "\n")
model = BDF(debug=False)
model.read_bdf(file.name, punch=True, xref=False)
model.nodes[3].cd = 20
model.cross_reference()

grids, axes = {}, {}
for label, grid in sorted(model.nodes.items()):
    grids[label] = list(map(float, grid.get_position()))
    reference = grid.cd_ref
    if grid.Cd():
        local = np.asarray(reference.transform_node_to_local(grid.get_position()), float)
        step = np.array([1e-6, 1e-4, 1e-4 if reference.type.endswith("S") else 1e-6])
        if reference.type.endswith("R"):
            step[:] = 1e-6
        rows = []
        for axis in range(3):
            h = np.zeros(3); h[axis] = step[axis]
            d = np.asarray(reference.transform_node_to_global(local + h)) - np.asarray(reference.transform_node_to_global(local - h))
            rows.append(list(map(float, d / np.linalg.norm(d))))
        axes[label] = rows
cells = {label: [int(n) if n else None for n in element.nodes] for label, element in sorted(model.elements.items())}
points = sorted(model.spoints)
json.dump({"grids": grids, "axes": axes, "cells": cells, "scalar_points": points}, open(os.path.join(HERE, "..", "nastran", "ugly.json"), "w"), indent=0)
