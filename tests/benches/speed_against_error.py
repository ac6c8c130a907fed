"""Speed against error for four mechanisms: `simulate` with fewer and more modes and shorter and longer steps, and Exudyn on the same bodies.

    pip install exudyn numpy scipy h5py
    python3 tests/benches/speed_against_error.py [--problems NAME,...] [--rounds 3] [--write] [--without-peers]

- `slider-crank`: the planar benchmark with a slender rod, two revolutions.
- `ivp-slider-crank`: that of the IVP test set, its rod as finite elements, 0.1 s.
- `solid-slider-crank`: the generated connecting rod, a hundredth as stiff as steel and damped, between a flywheel's crank and a slider, in space; judged
  over the second half, when the start has died out.
- `spinning-plate`: a thin plate in free flight, damped; judged over the second half.

Each run is compared with a run of the same mechanism with all modes that were reduced to (and centrifugal columns where it spins) and a step of a quarter
of the shortest; how far that is from the same with half of its step is told. The error is the largest distance of the deflection over all recorded times,
divided by the largest deflection. Times are those of the steps alone, on one thread, the least of all rounds; tools take turns. Exudyn gets the
matrices and the basis of the file (see `exudyn_mechanism.py`); planar beams have rotations at their nodes, which its reduced bodies don't take.
`--write` puts the raw lines in place of docs/data/speed_against_error.jsonl; `--example speed_against_error -- --render` makes page and pictures of them.
"""
import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

import chain_scene
import simulate_against_exudyn as runner

ROOT = runner.ROOT
DATA = os.path.join(ROOT, "docs", "data", "speed_against_error.jsonl")
BINARIES = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target")), "release")
UNITS = {"length": "m", "mass": "kg", "time": "s"}


def samples(folder, name, stem, *refinement):
    subprocess.check_call(
        [os.path.join(BINARIES, "samples"), "write", name, *refinement, "--stem", stem, "--out", folder], stdout=subprocess.DEVNULL
    )
    return os.path.join(folder, stem + ".mtx")


def reduce(part, output, modes, enrich=None):
    """Reduces a part; the file."""
    command = [os.path.join(BINARIES, "reduce"), part, "--modes", str(modes), "-o", output, "--force", "--quiet"]
    subprocess.check_call(command + (["--enrich", enrich] if enrich else []), stderr=subprocess.DEVNULL)
    return output


def description(part):
    with open(part.removesuffix(".mtx") + ".json") as file:
        return json.load(file)


def planar_slider_crank(folder, sample, crank, speed, slider, length, end, refinement=()):
    """A driven crank, a planar rod from its pin and a slider."""
    part = samples(folder, sample, sample, *refinement)
    middle = (len(description(part)["points"]) - 1) // 2
    scene = {
        "dimension": 2, "units": UNITS,
        "bodies": {
            "crank": {"rigid": {"mass": 0.36, "inertia": 0.002727, "points": {"axle": [0, 0], "pin": [crank, 0]}}, "angular_velocity": speed},
            "body": {"superelement": "", "position": [crank, 0], "velocity": [0, crank * speed], "angular_velocity": -crank * speed / length},
            "slider": {"rigid": {"mass": slider, "inertia": 1e-6, "points": {"pin": [0, 0]}}, "position": [crank + length, 0]},
        },
        "joints": {
            "axle": {"revolute": {"a": "ground", "b": "crank/axle"}},
            "wrist": {"revolute": {"a": "crank/pin", "b": "body/a"}},
            "pin": {"revolute": {"a": "body/b", "b": "slider/pin"}},
            "guide": {"prismatic": {"a": "ground", "b": "slider/pin", "axis": [1, 0]}},
        },
        "drives": {"motor": {"angle": {"joint": "axle", "polynomial": [0, speed]}}},
        "outputs": {"deflection": {"chord_deflection": {"body": "body", "node": middle, "between": ["a", "b"]}}},
    }
    return part, scene, end, None


def slider_crank(folder):
    part, scene, _, peer = planar_slider_crank(folder, "rod", 0.15, 150.0, 0.033377851, 0.3, 0.0, ("--refinement", "8"))
    return part, scene, 2 * 2 * np.pi / 150.0, peer


def ivp_slider_crank(folder):
    return planar_slider_crank(folder, "ivp-rod", 0.15, 150.0, 0.075552, 0.3, 0.1)


def solid_slider_crank(folder):
    steel = samples(folder, "connecting-rod", "steel", "--refinement", "0")
    part = os.path.join(folder, "solid.mtx")
    chain_scene.scaled(steel, part, SOFTER)
    for ending in (".mass.mtx", ".json"):
        shutil.copy(steel.removesuffix(".mtx") + ending, part.removesuffix(".mtx") + ending)
    about = description(part)
    about["component"]["damping"] = {"modal": chain_scene.DAMPING_RATIO}
    points = np.array(about["points"])
    for interface in about["component"]["interfaces"]:
        nodes = about["point_sets"][interface.pop("point_set")]
        interface["nodes"] = chain_scene.eight_nodes(about["points"], nodes)
        interface.pop("position", None)
    with open(part.removesuffix(".mtx") + ".json", "w") as file:
        json.dump(about, file)
    centres = [points[interface["nodes"]].mean(0) for interface in about["component"]["interfaces"]]
    length = float(centres[1][0] - centres[0][0])
    crank, speed, flywheel, slider = 0.3 * length, 150.0, 0.05, 0.3
    middle = int(np.argmin(np.linalg.norm(points - (centres[0] + centres[1]) / 2, axis=1)))
    spin = [0, 0, -crank * speed / length]
    position, velocity = [crank, 0, 0], [0, crank * speed, 0]
    scene = {
        "dimension": 3, "units": UNITS,
        "bodies": {
            "crank": {"rigid": {"mass": 1.0, "inertia": [flywheel] * 3, "points": {"axle": [0, 0, 0], "pin": [crank, 0, 0]}},
                      "angular_velocity": [0, 0, speed]},
            "body": {"superelement": "", "position": position, "velocity": velocity, "angular_velocity": spin},
            "slider": {"rigid": {"mass": slider, "inertia": [1e-4] * 3, "points": {"pin": [0, 0, 0]}}, "position": [crank + length, 0, 0]},
        },
        "joints": {
            "axle": {"revolute": {"a": "ground", "b": "crank/axle", "axis": [0, 0, 1]}},
            "wrist": {"revolute": {"a": "crank/pin", "b": "body/big-end", "axis": [0, 0, 1]}},
            "pin": {"spherical": {"a": "body/small-end", "b": "slider/pin"}},
            "guide": {"prismatic": {"a": "ground", "b": "slider/pin", "axis": [1, 0, 0]}},
        },
        "outputs": {"deflection": {"chord_deflection": {"body": "body", "node": middle, "between": ["big-end", "small-end"]}}},
    }
    peer = dict(kind="slider-crank", crank=crank, speed=speed, flywheel=flywheel, slider=slider, slider_position=[crank + length, 0, 0],
                position=position, velocity=velocity, angular_velocity=spin, node=middle)
    return part, scene, 0.06, peer


def spinning_plate(folder):
    part = samples(folder, "thin-plate", "plate")
    about = description(part)
    about["component"]["damping"] = {"modal": chain_scene.DAMPING_RATIO}
    with open(part.removesuffix(".mtx") + ".json", "w") as file:
        json.dump(about, file)
    points = np.array(about["points"])
    corner = int(np.argmax(points.sum(1)))
    spin = [10.0, 5.0, 200.0]
    velocity = np.cross(spin, -(points.max(0) + points.min(0)) / 2).tolist()
    scene = {
        "dimension": 3, "units": UNITS,
        "bodies": {"body": {"superelement": "", "angular_velocity": spin, "velocity": velocity}},
        "outputs": {"deflection": {"node_displacement": {"body": "body", "node": corner}}},
    }
    peer = dict(kind="free", position=[0, 0, 0], velocity=velocity, angular_velocity=spin, node=corner)
    return part, scene, 0.05, peer


# Name: parts and scene, modes of the reference, modes tried, steps tried, columns for centrifugal forces.
PROBLEMS = {
    "slider-crank": dict(make=slider_crank, all=24, modes=[1, 2, 3, 5, 8, 12], steps=[1.16e-5, 2.33e-5, 4.65e-5, 9.31e-5], spins=False),
    "ivp-slider-crank": dict(make=ivp_slider_crank, all=24, modes=[1, 2, 3, 5, 8], steps=[1e-5, 2e-5, 5e-5, 1e-4], spins=False),
    "solid-slider-crank": dict(make=solid_slider_crank, all=40, modes=[2, 5, 10, 20], steps=[1e-5, 2e-5, 5e-5, 1e-4], spins=False, judged=0.5),
    "spinning-plate": dict(make=spinning_plate, all=80, modes=[5, 10, 20, 40], steps=[2.5e-5, 5e-5, 1e-4], spins=True, judged=0.5),
}
RHO = 0.8
# Of steel: deflections are percents of the motion then, and steps resolve them.
SOFTER = 1e-2
RECORDS = 200


def run_ours(folder, scene, superelement, compatibility, step, end, records=RECORDS):
    """One run: seconds of the steps, times and deflections."""
    steps = max(records, round(end / step / records) * records)
    scene = json.loads(json.dumps(scene))
    scene["bodies"]["body"]["superelement"] = superelement
    scene["compatibility"] = compatibility
    scene["record"] = {"every": steps // records}
    scene["integrator"] = {"generalized_alpha": {"step": end / steps, "end": end, "rho_infinity": RHO}}
    path, results = os.path.join(folder, "scene.json"), os.path.join(folder, "results.h5")
    with open(path, "w") as file:
        json.dump(scene, file)
    runner.run([os.path.join(BINARIES, "simulate"), path, "-o", results, "--threads", "1", "--quiet", "--force"])
    with h5py.File(results) as file:
        summary = json.loads(file["provenance"].attrs["summary"])
        deflection = file["outputs/deflection"][:]
        return dict(
            seconds=summary["integration_seconds"], steps=summary["steps"], newton_iterations=summary["newton_iterations"],
            energy_defect=summary["energy_defect"] / max(summary["largest_energy"], 1e-300), time=file["time"][:],
            deflection=deflection.reshape(len(deflection), -1),
        )


def run_exudyn(folder, part, superelement, peer, step, end, scene):
    """The same by Exudyn; the deflection from positions, across the chord and in the plane's and its normal's direction."""
    steps = max(RECORDS, round(end / step / RECORDS) * RECORDS)
    job, result = os.path.join(folder, "job.json"), os.path.join(folder, "result.json")
    with open(job, "w") as file:
        json.dump(dict(peer, part=part, superelement=superelement, step=end / steps, steps=steps, rho_infinity=RHO, newton="modified",
                       record_every=steps // RECORDS, gravity=[0, 0, 0]), file)
    runner.run([sys.executable, os.path.join(runner.HERE, "exudyn_mechanism.py"), job, result])
    with open(result) as file:
        found = json.load(file)
    if not found["solved"] or max(found["defects"].values()) > 1e-8:
        sys.exit(f"Exudyn: {found}")
    common = dict(
        seconds=found["seconds"], steps=steps, newton_iterations=found["newton_iterations"], unknowns=found["unknowns"],
        version=found["version"], time=np.array(found["time"]),
    )
    if peer["kind"] == "free":
        return dict(common, deflection=np.array(found["local"]))
    node, a, b = (np.array(found[name]) for name in ("node", "a", "b"))
    points = np.array(description(part)["points"])
    between = scene["outputs"]["deflection"]["chord_deflection"]["between"]
    centre = {one["name"]: points[one["nodes"]].mean(0) for one in description(part)["component"]["interfaces"]}
    rest = centre[between[1]] - centre[between[0]]
    length = np.linalg.norm(rest)
    fraction = (points[peer["node"]] - centre[between[0]]) @ rest / length**2
    off = node - (1 - fraction) * a - fraction * b
    along = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    # The rod stays in the plane: what stands out of the chord there is its deflection, with the node's own distance from it.
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    own = (points[peer["node"]] - centre[between[0]] - fraction * rest)[1]
    return dict(common, deflection=((off[:, :2] * across).sum(1) - own)[:, None] / length)


def errors(found, reference, judged=1.0):
    """Largest and root mean square distance over the last part of the run, by the largest deflection of the reference there."""
    count = int(judged * min(len(found), len(reference)))
    reference = reference[-count:]
    width = min(found.shape[1], reference.shape[1])
    distance = np.linalg.norm(found[-count:, :width] - reference[:, :width], axis=1)
    size = np.linalg.norm(reference[:, :width], axis=1).max()
    return float(distance.max() / size), float(np.sqrt((distance**2).mean()) / size)


def in_plane(deflection):
    """The component across the rod in the plane of the mechanism."""
    return deflection[:, 1:2] if deflection.shape[1] > 1 else deflection


def study(name, problem, rounds, peers, folder):
    """Lines of one problem."""
    part, scene, end, peer = problem["make"](folder)
    best = reduce(part, os.path.join(folder, "all.dcb.h5"), problem["all"], "spin" if problem["spins"] else None)
    shortest = min(problem["steps"])
    reference, finer = (run_ours(folder, scene, best, "strong", shortest / part_of, end) for part_of in (4, 8))
    judged = problem.get("judged", 1.0)
    uncertainty = errors(reference["deflection"], finer["deflection"], judged)[0]
    reference = finer["deflection"]
    yield dict(kind="reference", problem=name, modes=problem["all"], step=shortest / 8, uncertainty=uncertainty, end=end, judged=judged,
               largest=float(np.linalg.norm(reference, axis=1).max()))
    files = {(modes, ""): reduce(part, os.path.join(folder, f"{modes}.dcb.h5"), modes) for modes in problem["modes"]}
    if problem["spins"]:
        for modes in problem["modes"]:
            files[modes, "spin"] = reduce(part, os.path.join(folder, f"{modes}-spin.dcb.h5"), modes, "spin")
    runs = [
        ("simulate", compatibility, modes, enrich, step)
        for (modes, enrich) in files
        for compatibility in (["strong"] if enrich or problem["spins"] else ["strong", "static"])
        for step in problem["steps"]
    ]
    if peer and peers:
        runs += [("exudyn", "strong", modes, "", step) for modes in problem["modes"] for step in problem["steps"]]
    times, last = {}, {}
    for _ in range(rounds):
        for run in random.sample(runs, len(runs)):
            tool, compatibility, modes, enrich, step = run
            superelement = files[modes, enrich]
            if tool == "simulate":
                found = run_ours(folder, scene, superelement, compatibility, step, end)
            else:
                found = run_exudyn(folder, part, superelement, peer, step, end, scene)
            times.setdefault(run, []).append(found["seconds"])
            last[run] = found
    for run in runs:
        tool, compatibility, modes, enrich, step = run
        found = last[run]
        expected = reference
        if peer and peer["kind"] == "slider-crank":
            found["deflection"], expected = in_plane(found["deflection"]), in_plane(reference)
        largest, mean = errors(found["deflection"], expected, judged)
        with h5py.File(files[modes, enrich]) as file:
            rank = file["residual/sigma2"].shape[0]
            columns = file["enrichment/interface_shapes"].shape[1] if "enrichment" in file else 0
        yield dict(
            kind="run", problem=name, tool=tool, compatibility=compatibility, modes=modes, enrich=enrich, step=step,
            coordinates=modes + (rank + columns if compatibility == "strong" else 0), seconds=min(times[run]), all_seconds=times[run],
            seconds_per_time=min(times[run]) / end, steps=found["steps"], newton_iterations=found["newton_iterations"], error=largest,
            mean_error=mean, energy_defect=found.get("energy_defect"), version=found.get("version"),
        )


def window(folder):
    """Inside the window of the paper's form: all three forms at its long steps, compared with all modes at the same steps."""
    part, scene, _, _ = planar_slider_crank(folder, "rod", 0.15, 150.0, 0.033377851, 0.3, 0.0, ("--refinement", "4"))
    end, count = 2 * 2 * np.pi / 150.0, 45
    step = end / (2 * count)
    best = reduce(part, os.path.join(folder, "all.dcb.h5"), 12)
    expected = run_ours(folder, scene, best, "strong", step, end, 2 * count)["deflection"]
    for modes in (5, 8):
        file = reduce(part, os.path.join(folder, f"{modes}.dcb.h5"), modes)
        with h5py.File(file) as opened:
            beside = {"strong": opened["residual/sigma2"].shape[0], "static": 0, "weak": opened["interfaces/dofs"].shape[0]}
        for compatibility in ("strong", "static", "weak"):
            found = run_ours(folder, scene, file, compatibility, step, end, 2 * count)["deflection"]
            largest, mean = errors(found, expected)
            yield dict(kind="window", compatibility=compatibility, modes=modes, coordinates=modes + beside[compatibility],
                       steps_per_revolution=count, error=largest, mean_error=mean)


def reductions(folder, rounds, peers):
    """The reduction itself: `reduce study` on the connecting rod, and SciPy making the same modes and attachments."""
    part = samples(folder, "connecting-rod", "connecting", "--refinement", "0")
    modes = [5, 10, 20, 40]
    out = os.path.join(folder, "connecting.study")
    runner.run([os.path.join(BINARIES, "reduce"), "study", part, "--modes", ",".join(map(str, modes)), "--variants", "strong,static,free", "--band", "10:4000",
                "-o", out, "--threads", "1", "--quiet"])
    with open(os.path.join(out, "study.json")) as file:
        rows = json.load(file)["rows"]
    errors_of = {}
    for row in rows:
        error = max(row["errors"]["collocated"]["largest"], row["errors"]["transfer"]["largest"])
        errors_of[row["variant"], row["modes"]] = error
        yield dict(kind="reduction", tool="reduce", variant=row["variant"], modes=row["modes"], unknowns=row["unknowns"],
                   seconds=row["reduction_seconds"], error=error)
    for count in modes if peers else []:
        found, times = os.path.join(folder, "scipy.json"), []
        for _ in range(rounds):
            runner.run([sys.executable, os.path.join(runner.HERE, "scipy_reduction.py"), part, str(count), found])
            with open(found) as file:
                theirs = json.load(file)
            times.append(sum(seconds for stage, seconds in theirs["stages"].items() if stage != "read"))
        with h5py.File(reduce(part, os.path.join(folder, "ours.dcb.h5"), count)) as file:
            ours = file["residual/flexibility"][:]
            frequencies = np.sqrt(file["modes/eigenvalues"][:]) / (2 * np.pi)
        difference = np.abs(ours - np.array(theirs["flexibility"])).max() / np.abs(ours).max()
        off = np.abs(frequencies / np.array(theirs["frequencies"])[: len(frequencies)] - 1).max()
        yield dict(kind="reduction", tool="scipy", variant="strong", modes=count, seconds=min(times), all_seconds=times,
                   error=errors_of["strong", count], flexibility_difference=float(difference), frequency_difference=float(off))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", default=",".join(PROBLEMS))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--without-peers", action="store_true")
    options = parser.parse_args()
    subprocess.check_call(["cargo", "build", "--release", "--quiet", "--bins"], cwd=ROOT)
    lines = [dict(kind="conditions", **runner.conditions(), rho_infinity=RHO)]
    lines[0]["command"] = "python3 tests/benches/speed_against_error.py " + " ".join(sys.argv[1:])
    for name in options.problems.split(","):
        with tempfile.TemporaryDirectory() as folder:
            for line in study(name, PROBLEMS[name], options.rounds, not options.without_peers, folder):
                lines.append(line)
                print(json.dumps(line), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for line in [*window(folder), *reductions(folder, options.rounds, not options.without_peers)]:
            lines.append(line)
            print(json.dumps(line), flush=True)
    if options.write:
        with open(DATA, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
