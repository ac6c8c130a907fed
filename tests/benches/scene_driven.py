"""What superelements made for a scene save: everything kept, a fixed number of modes, and `simulate prepare` at three tolerances,
with the scene's integrator and with one that it adapts.

    pip install numpy h5py
    python3 tests/benches/scene_driven.py [--scenes NAME,...] [--rounds 3] [--data FOLDER] [--write [FILE]] [--resume]

- `slider-crank`: the planar benchmark with a slender rod of 8 elements, two revolutions.
- `solid-slider-crank`: the generated connecting rod between a flywheel's crank and a slider, in space.
- `six-bodies`: crank, coupler, rocker, drag link, ram and a pendulum on the ram, in space; coupler, drag link and pendulum are connecting rods.

Everything and the fixed number of modes are run as they are (`--model everything`), prepared scenes as `simulate` runs a scene by default, which leaves out what
it doesn't need. The row "20 modes, adapted" has the step and the iteration's tolerance of the row that is adapted at 1e-3: what the integrator alone saves.
Errors are those of all outputs against the run with everything kept: the largest distance over all recorded times by the output's range, and the largest of
these. Times are those of the steps alone, on one thread, the least of all rounds; rows take turns. An adapted integrator doesn't change what a part is reduced
to: its preparation takes the reduction of the same tolerance from a cache, and counts what that took.

One JSON line per preparation and per run. `--write` puts each into docs/data/scene_driven.jsonl, or FILE, as it is made; a row that is made again
takes the place of that of an earlier commit. `--resume` leaves out what the file has for this commit (the last that touched the programs or the benches);
prepared scenes are kept in the data folder for that. `--example scene_driven` renders the page's part of the lines.
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
INTEGRATION = [[], ["--adapt-integrator"]]
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


def parts(scene, folder):
    """Superelements of a scene: all of them together, bytes."""
    files = {body["superelement"] for body in scene["bodies"].values() if "superelement" in body}
    return sum(os.path.getsize(os.path.join(folder, name)) for name in files)


def reduced(folder, scene, modes):
    """The scene with its part reduced to so many modes, in a folder of its own: what it took."""
    os.makedirs(folder)
    output = os.path.join(folder, "part.dcb.h5")
    start = time.perf_counter()
    single.reduce(os.path.join(os.path.dirname(folder), "part.mtx"), output, modes)
    seconds = time.perf_counter() - start
    write(os.path.join(folder, "scene.json"), scene)
    return dict(preparation_seconds=seconds, file_bytes=parts(scene, folder))


def prepared(folder, tolerance, options, reduction_seconds):
    """The scene as `simulate prepare` makes it: what it took, and its report."""
    above = os.path.dirname(folder)
    command = [os.path.join(BINARIES, "simulate"), "prepare", os.path.join(above, "scene.json"), "--tolerance", tolerance, "-o", folder]
    runner.run([*command, f"--cache={os.path.join(above, f'cache-{float(tolerance)}')}", "--quiet", "--force", *options])
    with open(os.path.join(folder, "report.json")) as file:
        report = json.load(file)
    for file in report["files"]:
        del file["from"]
    seconds = report["seconds"]["runs"] + (reduction_seconds or report["seconds"]["reduction"])
    return dict(preparation_seconds=seconds, file_bytes=sum(file["size"] for file in report["files"]), report=report)


def run(scene, model):
    results = scene.removesuffix(".json") + ".h5"
    runner.run([os.path.join(BINARIES, "simulate"), scene, "-o", results, "--model", model, "--threads", "1", "--quiet", "--force"])
    with h5py.File(results) as file:
        return json.loads(file["provenance"].attrs["summary"])


def error(folder, expected):
    """Largest distance by the range, of all outputs."""
    def outputs(of):
        with h5py.File(os.path.join(of, "scene.h5")) as file:
            return {name: data[:].reshape(len(data), -1) for name, data in file["outputs"].items() if data.dtype.kind == "f"}

    found, expected = outputs(folder), outputs(expected)

    def of(name):
        range_ = np.linalg.norm(np.ptp(expected[name], axis=0))
        return np.linalg.norm(found[name] - expected[name], axis=1).max() / range_
    return float(max(of(name) for name in expected))


class Bench:
    def __init__(self, options):
        self.options = options
        self.commit = commit()
        self.lines = []
        if options.write and os.path.exists(options.write):
            with open(options.write) as file:
                self.lines = [json.loads(text) for text in file]
        if not self.done("conditions"):
            machine = runner.conditions()["machine"]
            command = f"python3 tests/benches/scene_driven.py --rounds {options.rounds} --write"
            self.add("conditions", dict(commit=self.commit), command=command, machine=machine, rho_infinity=RHO)

    def done(self, kind, **key):
        """The line of this commit with this key."""
        return next((
            line for line in self.lines
            if line["kind"] == kind and line["commit"] == self.commit and all(line.get(name) == value for name, value in key.items())
        ), None)

    def add(self, kind, key, **values):
        """A line in place of that with the same key; a preparation also in place of the runs of what was prepared before."""
        line = dict(kind=kind, commit=self.commit) | key | values
        replaced = {"preparation": ["preparation", "run"]}.get(kind, [kind])
        is_replaced = lambda old: old["kind"] in replaced and all(old.get(name) == value for name, value in key.items())
        self.lines = [old for old in self.lines if not is_replaced(old)] + [line]
        used = {self.commit, *(line["commit"] for line in self.lines if line["kind"] != "conditions")}
        self.lines = [line for line in self.lines if line["commit"] in used]
        if self.options.write:
            with open(self.options.write + ".part", "w") as file:
                file.writelines(json.dumps(line) + "\n" for line in self.lines)
            os.replace(self.options.write + ".part", self.options.write)
        told = {name: value for name, value in line.items() if name != "report"}
        print(json.dumps(told), file=sys.stderr, flush=True)
        return line

    def study(self, name):
        make, everything = SCENES[name]
        folder = os.path.join(self.options.data, self.commit, name)
        os.makedirs(folder, exist_ok=True)
        scene, end, step = make(folder)
        # Steps up to sixteen times as long end at the times that are recorded.
        steps = round(end / step / RECORDS / 16) * 16 * RECORDS
        scene["record"] = {"every": steps // RECORDS}
        scene["integrator"] = {"generalized_alpha": {"step": end / steps, "end": end, "rho_infinity": RHO}}
        write(os.path.join(folder, "scene.json"), scene)
        rows = [dict(row="everything", modes=everything), dict(row=f"{FIXED} modes", modes=FIXED)] + [
            dict(row="scene-driven" + (", adapted" if options else ""), tolerance=float(tolerance), options=options)
            for tolerance in TOLERANCES for options in INTEGRATION
        ]
        places = [self.prepare(name, folder, scene, row) for row in rows]
        row, place = self.adapt_fixed(name, rows, places)
        rows.insert(2, row)
        places.insert(2, place)
        for round_number in range(self.options.rounds):
            for row, place in zip(rows, places):
                self.run(name, end, row, place, places[0], round_number)

    def adapt_fixed(self, name, rows, places):
        """The fixed number of modes with the integrator of the row that is adapted at 1e-3."""
        adapted = next(place for row, place in zip(rows, places) if row.get("options") and row["tolerance"] == 1e-3)
        with open(os.path.join(adapted, "scene.json")) as file:
            settings = json.load(file)
        place = places[1] + "-adapted"
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(places[1], place)
        path = os.path.join(place, "scene.json")
        with open(path) as file:
            scene = json.load(file)
        scene["integrator"], scene["record"] = settings["integrator"], settings["record"]
        write(path, scene)
        row = dict(row=f"{FIXED} modes, adapted", modes=FIXED)
        fixed = self.done("preparation", scene=name, row=f"{FIXED} modes", tolerance=None)
        values = {key: fixed[key] for key in ("preparation_seconds", "file_bytes")}
        self.add("preparation", dict(scene=name, row=row["row"], tolerance=None), **values)
        return row, place

    def prepare(self, name, folder, scene, row):
        """The folder of a row's scene, made if it isn't there."""
        key = dict(scene=name, row=row["row"], tolerance=row.get("tolerance"))
        words = row["row"].replace(",", "").split() + ([str(row["tolerance"])] if "tolerance" in row else [])
        place = os.path.join(folder, "-".join(words))
        if self.options.resume and self.done("preparation", **key) and os.path.exists(os.path.join(place, "scene.json")):
            return place
        shutil.rmtree(place, ignore_errors=True)
        if "modes" in row:
            made = reduced(place, scene, row["modes"])
        else:
            if not row["options"]:
                shutil.rmtree(os.path.join(folder, "cache-" + str(row["tolerance"])), ignore_errors=True)
            tolerance = next(text for text in TOLERANCES if float(text) == row["tolerance"])
            same = row["options"] and self.done("preparation", scene=name, row="scene-driven", tolerance=row["tolerance"])
            made = prepared(place, tolerance, row["options"], same and same["report"]["seconds"]["reduction"])
        self.add("preparation", key, step=scene["integrator"]["generalized_alpha"]["step"], **made)
        return place

    def run(self, name, end, row, place, expected, round_number):
        key = dict(scene=name, row=row["row"], tolerance=row.get("tolerance"), round=round_number)
        reference = os.path.join(expected, "scene.h5")
        if self.options.resume and self.done("run", **key) and (place != expected or os.path.exists(reference)):
            return
        summary = run(os.path.join(place, "scene.json"), "everything" if "modes" in row else "needed")
        self.add("run", key, seconds_per_second=summary["integration_seconds"] / end, error=error(place, expected), steps=summary["steps"],
                 iterations=summary["newton_iterations"], coordinates=summary["elastic_coordinates"], used_step=end / summary["steps"],
                 integrator=integrator(place))


def integrator(place):
    """How a scene is integrated, in words."""
    with open(os.path.join(place, "scene.json")) as file:
        [(method, settings)] = json.load(file)["integrator"].items()
    return f"radau, {settings['tolerance']:.0e}" if method == "radau" else method.replace("_", " ")


def commit():
    """The last commit that touched the programs or the benches, with a plus sign if they have changed since."""
    sources = "reducer", "formats", "runtime", "samples", "Cargo.toml", "Cargo.lock", "tests/benches"

    def git(*arguments):
        return subprocess.run(["git", "-C", ROOT, *arguments, "--", *sources], stdout=subprocess.PIPE, text=True).stdout.strip()

    return git("log", "-1", "--format=%h") + ("+" if git("status", "--porcelain") else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--data", default=os.path.join(tempfile.gettempdir(), "scene-driven-data"))
    parser.add_argument("--write", nargs="?", const=DATA, metavar="FILE")
    parser.add_argument("--resume", action="store_true")
    options = parser.parse_args()
    names = options.scenes.split(",")
    if unknown := set(names) - set(SCENES):
        parser.error(f"unknown scenes: {', '.join(sorted(unknown))}; there are {', '.join(SCENES)}")
    if options.resume and not options.write:
        parser.error("--resume needs --write, the file that says what is done")
    options.data = os.path.abspath(options.data)
    # As the tests build them: by themselves programs take other features, and minutes.
    subprocess.check_call(["cargo", "test", "--release", "--quiet", "--workspace", "--no-run"], cwd=ROOT)
    bench = Bench(options)
    for name in names:
        bench.study(name)


if __name__ == "__main__":
    main()
