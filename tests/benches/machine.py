"""A machine of four parts with 100 thousand degrees of freedom: reduced whole, as an assembly of its reduced parts, and as an assembly of two assemblies.

    pip install numpy scipy h5py pypardiso
    python3 tests/benches/machine.py [--cells 8] [--modes 40] [--write [FILE]]

The parts are steel blocks of quadratic hexahedra (`samples write block`), each with a stiffness and density of its own, joined face to face: the faces that meet move as one rigid
frame. The whole is the same matrices in one component. Compared are free frequencies (with the bounds that the assembly tells), F_res and mass properties, then the responses
of the machine held at one end to a force at the other at 1000 frequencies: from the assembly by `simulate`, and from the whole matrices by PARDISO, one factorization a frequency. The
responses are undamped, so that PARDISO works with real symmetric matrices, its best case; it solves every fiftieth frequency, and its time is given for one.

One JSON line each. `--write` puts them into docs/data/machine.jsonl or FILE. `--example render_pages` renders the page.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np
import scipy.io
import scipy.sparse as sp

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.path.join(ROOT, "docs", "data", "machine.jsonl")
BINARIES = os.path.join(ROOT, "target", "release")
LENGTH = 0.4
STIFFNESS = [1.0, 0.7, 1.3, 0.5]    # times that of steel
DENSITY = [1.0, 0.9, 1.2, 0.6]
FREQUENCIES = 1000
SOLVED = 50                         # PARDISO solves every fiftieth


def run(*arguments, folder):
    start = time.perf_counter()
    done = subprocess.run([os.path.join(BINARIES, arguments[0]), *arguments[1:]], cwd=folder, capture_output=True, text=True)
    seconds = time.perf_counter() - start
    if done.returncode:
        sys.exit(f"{' '.join(arguments)}\n{done.stderr}")
    return done.stdout, seconds


def symmetric(path):
    return sp.csr_matrix(scipy.io.mmread(path))


def make_parts(folder, cells):
    """part1 to part4 with rigid interfaces a and b, and whole."""
    run("samples", "write", "block", "--refinement", str(cells), "--stem", "block", "--out", folder, folder=folder)
    stiffness, mass = (symmetric(os.path.join(folder, name)) for name in ("block.mtx", "block.mass.mtx"))
    with open(os.path.join(folder, "block.json")) as file:
        description = json.load(file)
    points = np.array(description["points"])
    points[:, 0] -= points[:, 0].min()
    nodes = len(points)
    ends = [np.flatnonzero(abs(points[:, 0] - x) < 1e-9).tolist() for x in (0.0, LENGTH)]
    middle = points[ends[0]].mean(axis=0)
    units, dofs = description["component"]["units"], description["component"]["dofs"]
    cell_block = description["cells"][0]

    def write(name, k, m, coordinates, cells, interfaces):
        scipy.io.mmwrite(os.path.join(folder, f"{name}.mtx"), k, symmetry="symmetric", precision=17)
        scipy.io.mmwrite(os.path.join(folder, f"{name}.mass.mtx"), m, symmetry="symmetric", precision=17)
        component = {"name": name, "units": units, "dofs": dofs, "interfaces": interfaces}
        with open(os.path.join(folder, f"{name}.json"), "w") as file:
            json.dump({"points": coordinates.tolist(), "cells": cells, "component": component}, file)

    def face(name, ids, x, role="attachment"):
        return {"name": name, "kind": "rigid", "nodes": ids, "position": [x, float(middle[1]), float(middle[2])], "role": role}

    def moved(i):
        return points + np.array([i * LENGTH, 0, 0])

    for i in range(4):
        write(f"part{i + 1}", STIFFNESS[i] * stiffness, DENSITY[i] * mass, moved(i), [cell_block],
              [face("a", ends[0], i * LENGTH), face("b", ends[1], (i + 1) * LENGTH)])
    whole_cells = [{"type": cell_block["type"], "data": [[node + i * nodes for node in cell] for i in range(4) for cell in cell_block["data"]]}]
    shifted = lambda ids, i: [node + i * nodes for node in ids]
    joints = [face(f"joint{i}", shifted(ends[1], i - 1) + shifted(ends[0], i), i * LENGTH, "output") for i in (1, 2, 3)]
    k = sp.block_diag([factor * stiffness for factor in STIFFNESS]).tocsr()
    m = sp.block_diag([factor * mass for factor in DENSITY]).tocsr()
    write("whole", k, m, np.concatenate([moved(i) for i in range(4)]), whole_cells,
          [face("a", ends[0], 0.0), *joints, face("b", shifted(ends[1], 3), 4 * LENGTH)])
    frames = [(ends[0], 0.0), *[(joint["nodes"], joint["position"][0]) for joint in joints], (shifted(ends[1], 3), 4 * LENGTH)]
    return k, m, np.concatenate([moved(i) for i in range(4)]), [(ids, np.array([x, middle[1], middle[2]])) for ids, x in frames]


def assembly(folder, name, bodies, joints, interfaces):
    text = {"dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
            "bodies": {body: {"superelement": f"{file}.dcb.h5"} for body, file in bodies.items()},
            "joints": {f"joint{i}": {"fixed": {"a": a, "b": b}} for i, (a, b) in enumerate(joints)}, "interfaces": interfaces}
    with open(os.path.join(folder, f"{name}.json"), "w") as file:
        json.dump(text, file)


def stored(folder, name):
    with h5py.File(os.path.join(folder, f"{name}.dcb.h5")) as file:
        moments = "error" in file
        return {"squares": file["modes/eigenvalues"][()], "flexibility": file["residual/flexibility"][()], "shapes": file["modes/interface_shapes"][()],
                "names": list(file["interfaces/names"].asstr()[()]), "rows": file["interfaces/dofs"][()],
                "mass": float(file["inertia/mass"][()]), "tensor": file["inertia/tensor"][()], "origin": file["frame/origin"][()],
                "errors": file["error/eigenvalue_errors"][()] if moments else None, "rank": len(file["residual/sigma2"])}


def ends_of(element):
    """Rows of a, then of b."""
    index = [element["names"].index(name) for name in ("a", "b")]
    return [row for of in index for row in np.flatnonzero(element["rows"][:, 0] == of)]


def flexibility(element):
    """Static flexibility at a and b, inertia relieved: modes and residual."""
    rows = ends_of(element)
    shapes = element["shapes"][rows]
    return shapes / element["squares"] @ shapes.T + element["flexibility"][np.ix_(rows, rows)]


def condensed(k, m, coordinates, frames):
    """K and M with the faces as rigid frames, their dofs last; frame after frame."""
    n = k.shape[0]
    in_frame = np.concatenate([np.asarray(ids) for ids, _ in frames])
    free = np.setdiff1d(np.arange(n // 3), in_frame)
    rows, columns, values = [], [], []

    def put(row, column, value):
        rows.append(row), columns.append(column), values.append(value)

    for place, node in enumerate(free):
        for axis in range(3):
            put(3 * node + axis, 3 * place + axis, 1.0)
    for number, (ids, centre) in enumerate(frames):
        first = 3 * len(free) + 6 * number
        for node in ids:
            x, y, z = coordinates[node] - centre
            turn = [[0, z, -y], [-z, 0, x], [y, -x, 0]]      # u = t + r x arm
            for axis in range(3):
                put(3 * node + axis, first + axis, 1.0)
                for about in range(3):
                    if turn[axis][about]:
                        put(3 * node + axis, first + 3 + about, turn[axis][about])
    t = sp.csr_matrix((values, (rows, columns)), shape=(n, 3 * len(free) + 6 * len(frames)))
    return (t.T @ k @ t).tocsr(), (t.T @ m @ t).tocsr(), 3 * len(free)


def frf_scene(folder, file, origin):
    scene = {"dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
             "ground": {"points": {"wall": origin}}, "bodies": {"machine": {"superelement": f"{file}.dcb.h5"}},
             "joints": {"clamp": {"fixed": {"a": "ground/wall", "b": "machine/a"}}},
             "loads": {"push": {"force": {"at": "machine/b", "components": [0, 1, 0]}}},
             "outputs": {"tip": {"displacement": {"at": "machine/b"}}},
             "analysis": {"frequency_response": {"inputs": ["push"], "frequencies": FREQUENCY_LIST}}}
    with open(os.path.join(folder, f"frf-{file}.json"), "w") as out:
        json.dump(scene, out)


def responses(folder, file):
    text, seconds = run("simulate", f"frf-{file}.json", "--force", "-o", f"frf-{file}.h5", folder=folder)
    with h5py.File(os.path.join(folder, f"frf-{file}.h5")) as results:
        real = results["frequency_response/real"]
        names = [str(name) for name in real.attrs["outputs"]]
        values, errors = real[()], results["frequency_response/error"][()]
    place = [name.endswith(".y") for name in names].index(True)
    return values[:, place, 0], errors[:, place, 0], seconds, text.splitlines()[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=8)
    parser.add_argument("--modes", type=int, default=40)
    parser.add_argument("--write", nargs="?", const=DATA)
    parser.add_argument("--without-direct", action="store_true", help="leave PARDISO out")
    arguments = parser.parse_args()
    lines = []

    def say(**line):
        lines.append(line)
        print(json.dumps(line), flush=True)

    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "")
    import scipy
    versions = {"python": sys.version.split()[0], "numpy": np.__version__, "scipy": scipy.__version__}
    with tempfile.TemporaryDirectory() as folder:
        k, m, coordinates, frames = make_parts(folder, arguments.cells)
        say(kind="conditions", command="python3 tests/benches/machine.py " + " ".join(sys.argv[1:]), commit=git,
            machine={"cpu": cpu, "cores": os.cpu_count()}, versions=versions, dofs=k.shape[0], modes=arguments.modes)
        modes = str(arguments.modes)
        _, whole_seconds = run("reduce", "whole.mtx", "--modes", modes, "--without-fields", "-o", "whole.dcb.h5", folder=folder)
        say(kind="reduction", what="whole", unknowns=k.shape[0], seconds=whole_seconds)
        part_seconds = [run("reduce", f"part{i}.mtx", "--modes", modes, "--without-fields", "-o", f"part{i}.dcb.h5", folder=folder)[1] for i in (1, 2, 3, 4)]
        say(kind="reduction", what="four parts", unknowns=k.shape[0] // 4, seconds=sum(part_seconds))
        parts = {f"p{i}": f"part{i}" for i in (1, 2, 3, 4)}
        assembly(folder, "machine", parts, [("p1/b", "p2/a"), ("p2/b", "p3/a"), ("p3/b", "p4/a")], {"a": "p1/a", "b": "p4/b"})
        _, seconds = run("reduce", "assemble", "machine.json", "--modes", modes, folder=folder)
        sizes = [len(stored(folder, f"part{i}")["squares"]) + stored(folder, f"part{i}")["rank"] + 6 for i in (1, 2, 3, 4)]
        say(kind="reduction", what="assembly of four", unknowns=sum(sizes), seconds=seconds)
        two = 0.0
        for name, (i, j) in {"left": (1, 2), "right": (3, 4)}.items():
            assembly(folder, name, {"p": f"part{i}", "q": f"part{j}"}, [("p/b", "q/a")], {"a": "p/a", "b": "q/b"})
            two += run("reduce", "assemble", f"{name}.json", "--modes", modes, folder=folder)[1]
        assembly(folder, "levels", {"l": "left", "r": "right"}, [("l/b", "r/a")], {"a": "l/a", "b": "r/b"})
        two += run("reduce", "assemble", "levels.json", "--modes", modes, folder=folder)[1]
        halves = [stored(folder, name) for name in ("left", "right")]
        say(kind="reduction", what="assembly of two assemblies", unknowns=sum(len(half["squares"]) + half["rank"] + 6 for half in halves), seconds=two)

        whole, one, levels = (stored(folder, name) for name in ("whole", "machine", "levels"))
        for place in range(arguments.modes):
            exact = whole["squares"][place]
            say(kind="frequency", mode=place + 1, hertz=float(np.sqrt(exact) / (2 * np.pi)),
                **{name: float(np.sqrt(of["squares"][place] / exact) - 1) for name, of in (("one_level", one), ("two_levels", levels))},
                **{f"{name}_bound": float(np.sqrt(1 + of["errors"][place]) - 1) for name, of in (("one_level", one), ("two_levels", levels)) if of["errors"] is not None})
        reference = flexibility(whole)
        scale = np.sqrt(np.outer(np.diag(reference), np.diag(reference)))
        for name, of in (("one_level", one), ("two_levels", levels)):
            say(kind="statics", what=name, flexibility=float(np.abs((flexibility(of) - reference) / scale).max()), mass=abs(of["mass"] / whole["mass"] - 1),
                tensor=float(np.abs(of["tensor"] - whole["tensor"]).max() / np.abs(whole["tensor"]).max()),
                origin=float(np.abs(of["origin"] - whole["origin"]).max() / (4 * LENGTH)))

        global FREQUENCY_LIST
        highest = 0.25 * np.sqrt(whole["squares"][-1]) / (2 * np.pi)
        FREQUENCY_LIST = np.linspace(highest / FREQUENCIES, highest, FREQUENCIES).tolist()
        wall = [0.0, float(frames[0][1][1]), float(frames[0][1][2])]
        found = {}
        for file in ("whole", "machine", "levels"):
            frf_scene(folder, file, wall)
            *found[file], seconds, verdict = responses(folder, file)
            say(kind="response", what=file, frequencies=FREQUENCIES, seconds=seconds, verdict=verdict)
        if not arguments.without_direct:
            import pypardiso
            kc, mc, first = condensed(k, m, coordinates, frames)
            kept = np.concatenate([np.arange(first), np.arange(first + 6, kc.shape[0])])
            kc, mc = kc[kept][:, kept], mc[kept][:, kept]
            load = np.zeros(len(kept))
            load[-6 + 1] = 1.0
            solver = pypardiso.PyPardisoSolver(mtype=-2)
            direct, times = [], []
            solved = list(range(SOLVED // 2, FREQUENCIES, SOLVED))
            for place in solved:
                omega = 2 * np.pi * FREQUENCY_LIST[place]
                start = time.perf_counter()
                upper = sp.triu(kc - omega**2 * mc, format="csr")
                direct.append(solver.solve(upper, load)[-6 + 1])
                times.append(time.perf_counter() - start)
                solver.free_memory(everything=True)
            direct = np.array(direct)
            say(kind="direct", solved=len(solved), seconds_each=float(np.median(times)), unknowns=len(kept), pypardiso=pypardiso.__version__)
            for file, (response, told) in found.items():
                off, told = np.abs(response[solved] / direct - 1), told[solved] / np.abs(response[solved])
                say(kind="accuracy", what=file, median=float(np.median(off)), p90=float(np.quantile(off, 0.9)), largest=float(off.max()),
                    told_median=float(np.median(told)), told_largest=float(told.max()), least_told_by_true=float((told / off).min()), most_told_by_true=float((told / off).max()))
    if arguments.write:
        with open(arguments.write, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
