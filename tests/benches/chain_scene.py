"""The chain of connecting rods that `simulate_against_exudyn.py` runs: its component, its superelement and its scene."""
import json
import os
import shutil
import subprocess

GRAVITY = [0, -9.81, 0]
DAMPING_RATIO = 0.03  # of every coordinate; lets the vibration of the release die, so that answers can be compared
RECORDS = 10  # a run


def eight_nodes(points, nodes):
    """Two opposite faces of a bore, four nodes a quarter turn apart on each; their centroid is the bore's centre."""
    ring = [points[node] for node in nodes]
    centre = [(min(p[axis] for p in ring) + max(p[axis] for p in ring)) / 2 for axis in range(3)]
    radius = (max(p[0] for p in ring) - min(p[0] for p in ring)) / 2
    faces = min(p[2] for p in ring), max(p[2] for p in ring)
    corners = [
        (centre[0] + x * radius, centre[1] + y * radius, z) for z in faces for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1))
    ]
    return [min(nodes, key=lambda node: sum((a - b) ** 2 for a, b in zip(points[node], corner))) for corner in corners]


def scaled(source, target, factor):
    """Copies a Matrix Market file with every value times `factor`."""
    with open(source) as lines, open(target, "w") as out:
        header = True
        for line in lines:
            if line.startswith("%") or header:
                header = line.startswith("%")
                out.write(line)
            else:
                row, column, value = line.split()
                out.write(f"{row} {column} {float(value) * factor!r}\n")


def write_component(binaries, folder, case):
    """Writes the part of a case and reduces it; its part file, its superelement and the centroids of its two interfaces."""
    subprocess.check_call(
        [os.path.join(binaries, "samples"), "write", "connecting-rod", "--refinement", "0", "--stem", "steel", "--out", folder],
        stdout=subprocess.DEVNULL,
    )
    source, stem = os.path.join(folder, "steel"), os.path.join(folder, case["name"])
    scaled(source + ".mtx", stem + ".mtx", case["stiffness_factor"])
    shutil.copy(source + ".mass.mtx", stem + ".mass.mtx")
    with open(source + ".json") as file:
        description = json.load(file)
    points, component = description["points"], description["component"]
    component["damping"] = {"modal": DAMPING_RATIO}
    centres = []
    for interface in component["interfaces"]:
        nodes = description["point_sets"][interface.pop("point_set")]
        interface["nodes"] = eight_nodes(points, nodes) if case["interface"] == "8 nodes" else nodes
        del interface["position"]  # the centroid
        count = len(interface["nodes"])
        centres.append([sum(points[node][axis] for node in interface["nodes"]) / count for axis in range(3)])
    attachments = 12
    if case["coordinates"] <= attachments:
        component["interfaces"][1]["role"] = "output"
        attachments = 6
    with open(stem + ".json", "w") as file:
        json.dump(description, file)
    subprocess.check_call(
        [os.path.join(binaries, "reduce"), stem + ".mtx", "--modes", str(case["coordinates"] - attachments), "--force", "--quiet"]
    )
    return stem + ".mtx", stem + ".dcb.h5", centres


def scene(case, superelement, centres, step, steps):
    """The scene as `simulate` reads it."""
    pitch = [there - here for here, there in zip(*centres)]
    names = [f"rod{index}" for index in range(1, case["bodies"] + 1)]
    attachments = ["ground/pivot"] + [f"{name}/small-end" for name in names]
    return {
        "dimension": 3,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "gravity": GRAVITY,
        "ground": {"points": {"pivot": centres[0]}},
        "bodies": {
            name: {"superelement": superelement, "position": [index * p for p in pitch]} for index, name in enumerate(names)
        },
        "joints": {
            f"hinge{index}": {"revolute": {"a": before, "b": f"{name}/big-end", "axis": [0, 0, 1]}}
            for index, (before, name) in enumerate(zip(attachments, names), 1)
        },
        "outputs": {"tip": {"position": {"at": attachments[-1]}}},
        "record": {"every": steps // RECORDS},
        "integrator": {
            "generalized_alpha": {"step": step, "end": round(steps * step, 12), "rho_infinity": case["rho_infinity"]}
        },
    }
