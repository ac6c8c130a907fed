"""What superelements made for a scene save: everything kept, a fixed number of modes, and `simulate prepare` at three tolerances,
with the scene's steps and with steps that it lengthens.

    pip install numpy h5py
    python3 tests/benches/scene_driven.py [--scenes NAME,...] [--rounds 3] [--write]

- `slider-crank`: the planar benchmark with a slender rod of 8 elements, two revolutions.
- `solid-slider-crank`: the generated connecting rod between a flywheel's crank and a slider, in space.
- `six-bodies`: crank, coupler, rocker, drag link, ram and a pendulum on the ram, in space; coupler, drag link and pendulum are connecting rods.

Every row runs with the same step and method. Errors are those of all outputs against the run with everything kept: the largest distance over all
recorded times by the output's range, and the largest of these. Times are those of the steps alone, on one thread, the least of all rounds; rows take
turns. `--write` puts the raw lines in place of docs/data/scene_driven.jsonl; `--example scene_driven` renders the page's part of them.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

import simulate_against_exudyn as runner
import speed_against_error as single

ROOT = runner.ROOT
DATA = os.path.join(ROOT, "docs", "data", "scene_driven.jsonl")
BINARIES = single.BINARIES
FIXED = 20  # modes of the row that counts them by hand
TOLERANCES = ["1e-2", "1e-3", "1e-4"]
STEPS = [[], ["--lengthen-steps"]]
RECORDS = 100
RHO = 0.8


def one_body(make, step):
    """One of the mechanisms of `speed_against_error.py`, its flexible body as `part.dcb.h5`."""
    def write(folder):
        part, scene, end, _ = make(folder)
        for ending in (".mtx", ".mass.mtx", ".json"):
            shutil.copy(part.removesuffix(".mtx") + ending, os.path.join(folder, "part" + ending))
        for other in sorted(os.listdir(folder)):
            stem = os.path.basename(part).removesuffix(".mtx")
            if other.startswith(stem + ".mass.") and other != stem + ".mass.mtx":
                shutil.copy(os.path.join(folder, other), os.path.join(folder, "part" + other.removeprefix(stem)))
        scene["bodies"]["body"]["superelement"] = "part.dcb.h5"
        scene["outputs"]["slider"] = {"position": {"at": "slider/pin"}}
        return scene, end, step
    return write


def six_bodies(folder):
    """A crank-rocker with a drag link to a ram, and a pendulum on the ram."""
    part, scene, _, _ = single.solid_slider_crank(folder)
    for ending in (".mtx", ".mass.mtx", ".json"):
        shutil.copy(part.removesuffix(".mtx") + ending, os.path.join(folder, "part" + ending))
    node = scene["outputs"]["deflection"]["chord_deflection"]["node"]
    length = scene["bodies"]["slider"]["position"][0] - scene["bodies"]["crank"]["rigid"]["points"]["pin"][0]
    crank, speed = 0.3 * length, 150.0
    pulled = [-crank * speed, 0, 0]
    rod = {"superelement": "part.dcb.h5", "velocity": pulled}
    across = [0, 0, 1]
    bodies = {
        "crank": {"rigid": {"mass": 1.0, "inertia": [0.05] * 3, "points": {"axle": [0, 0, 0], "pin": [0, crank, 0]}}, "angular_velocity": [0, 0, speed]},
        "coupler": dict(rod, position=[0, crank, 0]),
        "rocker": {"rigid": {"mass": 0.5, "inertia": [2e-3] * 3, "points": {"pivot": [0, 0, 0], "top": [0, length, 0]}},
                   "position": [length, crank - length, 0], "angular_velocity": [0, 0, crank * speed / length]},
        "drag": dict(rod, position=[length, crank, 0]),
        "ram": {"rigid": {"mass": 0.3, "inertia": [1e-4] * 3, "points": {"pin": [0, 0, 0]}}, "position": [2 * length, crank, 0], "velocity": pulled},
        "pendulum": dict(rod, position=[2 * length, crank, 0]),
    }
    joints = {
        "axle": {"revolute": {"a": "ground", "b": "crank/axle", "axis": across}},
        "wrist": {"revolute": {"a": "crank/pin", "b": "coupler/big-end", "axis": across}},
        "elbow": {"spherical": {"a": "coupler/small-end", "b": "rocker/top"}},
        "pivot": {"revolute": {"a": "ground/pivot", "b": "rocker/pivot", "axis": across}},
        "knee": {"revolute": {"a": "rocker/top", "b": "drag/big-end", "axis": across}},
        "pin": {"spherical": {"a": "drag/small-end", "b": "ram/pin"}},
        "guide": {"prismatic": {"a": "ground/guide", "b": "ram/pin", "axis": [1, 0, 0]}},
        "hinge": {"revolute": {"a": "ram/pin", "b": "pendulum/big-end", "axis": across}},
    }
    chord = lambda body: {"chord_deflection": {"body": body, "node": node, "between": ["big-end", "small-end"]}}
    scene = {
        "dimension": 3, "units": single.UNITS, "bodies": bodies, "joints": joints,
        "ground": {"points": {"pivot": [length, crank - length, 0], "guide": [0, crank, 0]}},
        "outputs": {"coupler": chord("coupler"), "drag": chord("drag"), "ram": {"position": {"at": "ram/pin"}},
                    "tip": {"position": {"at": "pendulum/small-end"}}},
    }
    return scene, 0.04, 2e-5


# Name: how it is written, and how many modes are everything.
SCENES = {
    "slider-crank": (one_body(single.slider_crank, 1.16e-5), 24),
    "solid-slider-crank": (one_body(single.solid_slider_crank, 2e-5), 320),
    "six-bodies": (six_bodies, 320),
}


def write(path, scene):
    with open(path, "w") as file:
        json.dump(scene, file)


def reduced(folder, scene, modes):
    """The scene with its part reduced to so many modes, in a folder of its own: scene file, seconds, bytes."""
    os.makedirs(folder)
    output = os.path.join(folder, "part.dcb.h5")
    start = time.perf_counter()
    single.reduce(os.path.join(os.path.dirname(folder), "part.mtx"), output, modes)
    seconds = time.perf_counter() - start
    write(os.path.join(folder, "scene.json"), scene)
    return os.path.join(folder, "scene.json"), seconds, os.path.getsize(output)


def prepared(folder, tolerance, *options):
    """The scene as `simulate prepare` makes it: scene file, seconds, bytes, report."""
    scene = os.path.join(os.path.dirname(folder), "scene.json")
    start = time.perf_counter()
    runner.run([os.path.join(BINARIES, "simulate"), "prepare", scene, "--tolerance", tolerance, "-o", folder, "--quiet", *options])
    seconds = time.perf_counter() - start
    with open(os.path.join(folder, "report.json")) as file:
        report = json.load(file)
    sizes = [os.path.getsize(os.path.join(folder, name)) for name in os.listdir(folder) if name.endswith(".dcb.h5")]
    return os.path.join(folder, "scene.json"), seconds, sum(sizes), report


def run(scene):
    results = scene.removesuffix(".json") + ".h5"
    runner.run([os.path.join(BINARIES, "simulate"), scene, "-o", results, "--model", "everything", "--threads", "1", "--quiet", "--force"])
    with h5py.File(results) as file:
        summary = json.loads(file["provenance"].attrs["summary"])
        outputs = {name: data[:].reshape(len(data), -1) for name, data in file["outputs"].items()}
    return summary, outputs


def error(found, expected):
    """Largest distance by the range, of all outputs."""
    def of(name):
        range_ = np.linalg.norm(np.ptp(expected[name], axis=0))
        return np.linalg.norm(found[name] - expected[name], axis=1).max() / range_
    return float(max(of(name) for name in expected))


def study(name, rounds, folder):
    make, everything = SCENES[name]
    scene, end, step = make(folder)
    # Steps up to sixteen times as long end at the times that are recorded.
    steps = round(end / step / RECORDS / 16) * 16 * RECORDS
    scene["record"] = {"every": steps // RECORDS}
    scene["integrator"] = {"generalized_alpha": {"step": end / steps, "end": end, "rho_infinity": RHO}}
    write(os.path.join(folder, "scene.json"), scene)
    rows = [dict(row="everything"), dict(row=f"{FIXED} modes")] + [
        dict(row="scene-driven" + (", longer steps" if options else ""), tolerance=float(t)) for t in TOLERANCES for options in STEPS
    ]
    files = []
    for row, modes in zip(rows, (everything, FIXED)):
        path, row["preparation_seconds"], row["file_bytes"] = reduced(os.path.join(folder, row["row"].replace(" ", "-")), scene, modes)
        files.append(path)
    for row, (tolerance, options) in zip(rows[2:], [(t, o) for t in TOLERANCES for o in STEPS]):
        target = os.path.join(folder, "-".join(["at", tolerance, *options]))
        path, row["preparation_seconds"], row["file_bytes"], row["report"] = prepared(target, tolerance, *options)
        files.append(path)
    expected = None
    for _ in range(rounds):
        for row, path in zip(rows, files):
            summary, outputs = run(path)
            expected = expected or outputs
            row.setdefault("seconds", []).append(summary["integration_seconds"])
            row["error"] = error(outputs, expected)
            row["steps"], row["iterations"] = summary["steps"], summary["newton_iterations"]
            row["coordinates"], row["used_step"] = summary["elastic_coordinates"], end / summary["steps"]
    for row in rows:
        yield dict(kind="row", scene=name, end=end, step=end / steps, seconds_per_second=min(row["seconds"]) / end, **row)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    subprocess.check_call(["cargo", "build", "--release", "--quiet", "--bins"], cwd=ROOT)
    lines = [dict(kind="conditions", **runner.conditions(), rho_infinity=RHO)]
    lines[0]["command"] = "python3 tests/benches/scene_driven.py " + " ".join(sys.argv[1:])
    for name in options.scenes.split(","):
        with tempfile.TemporaryDirectory() as folder:
            for line in study(name, options.rounds, folder):
                lines.append(line)
                print(json.dumps(line), flush=True)
    if options.write:
        with open(DATA, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
