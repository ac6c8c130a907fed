"""Work against precision of the integrators: `radau` of both orders and generalized alpha, and Exudyn, SciPy's Radau IIA and SUNDIALS IDA where they run.

    pip install exudyn scikit-sundae numpy scipy h5py matplotlib
    cargo build --release -p dcb-programs -p dcb-samples
    python3 tests/benches/work_precision.py [--problems NAME,...] [--rounds 3] [--write] [--without-peers]
    python3 tests/benches/work_precision.py --render          # page and pictures from the lines

The mechanisms are those of `speed_against_error.py`, each with one reduced body of a fixed number of modes, so that the integration is all that errs, and a
chain of 16 soft connecting rods, for as long as it starts to fall and for its first swing. The reference is `radau` of order 9 at 1e-11; how far order 5 at 1e-10 is from it is told. The error is the largest
distance of the deflection (of the chain: of the last body's free end) over all recorded times, divided by the largest; the time is that of the
integration alone, on one thread, the least of the rounds; tools take turns. Peers run within the same rounds. All carry every coordinate of the file.
Forces are those of the joint at the flexible body, over the recorded times, by the largest; "with forces held" runs have a tolerance of 1e-2 for the motion and
one for the forces.
"""
import argparse
import json
import os
import random
import sys
import tempfile

import h5py
import numpy as np

import chain_scene
import simulate_against_exudyn as runner
import speed_against_error as mechanisms

ROOT = runner.ROOT
DATA = os.path.join(ROOT, "docs", "data", "work_precision.jsonl")
PAGE = os.path.join(ROOT, "docs", "speed-against-error.md")
PICTURES = os.path.join(ROOT, "docs", "pictures")
BEGIN, END = "<!-- generated from data/work_precision.jsonl -->", "<!-- end of the work-precision part -->"
RECORDS = 200
RHO = 0.8
TOLERANCES = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]
# How long the chain falls, s.
CHAINS = {"chain-16": 0.1, "chain-16-swing": 1.0}
STEPS = [1000, 4000, 16000, 64000, 256000]
# Further ones of generalized_alpha: shorter where it is still above 1e-6, longer for the chain, whose motion is smooth.
FURTHER_STEPS = {"slider-crank": [1024000, 4096000], "ivp-slider-crank": [1024000, 4096000], **dict.fromkeys(CHAINS, [200, 400])}
PEER_STEPS = [1000, 4000, 16000]
# Runs shorter than that, s, are made so many times a round: a neighbour's moment would be all of them.
SHORT, REPEATED = 0.3, 4
WANTED = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]
# Name: number of modes.
MODES = {"slider-crank": 5, "ivp-slider-crank": 8, "solid-slider-crank": 10, "spinning-plate": 10}
# The joint whose force is looked at.
JOINTS = {"slider-crank": "wrist", "ivp-slider-crank": "wrist", "solid-slider-crank": "wrist", **dict.fromkeys(CHAINS, "hinge1")}
FORCE_TOLERANCES = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
CHAIN = dict(runner.case(16, 16, soft=True), newton=["modified"])


def simulate(folder, scene, integrator, end, output):
    scene = dict(json.loads(json.dumps(scene)), integrator=integrator, record={"interval": end / RECORDS})
    path, results = os.path.join(folder, "scene.json"), os.path.join(folder, "results.h5")
    with open(path, "w") as file:
        json.dump(scene, file)
    runner.run([os.path.join(mechanisms.BINARIES, "simulate"), path, "-o", results, "--threads", "1", "--quiet", "--force", "--model", "everything"])
    with h5py.File(results) as file:
        summary = json.loads(file["provenance"].attrs["summary"])
        deflection = file["outputs/" + output][:]
        force = file["outputs/force"][:][:, :3] if "force" in scene["outputs"] else None
    return dict(
        force=force,
        seconds=summary["integration_seconds"], steps=summary["steps"], newton_iterations=summary["newton_iterations"],
        jacobian_updates=summary["jacobian_updates"], deflection=deflection.reshape(len(deflection), -1),
    )


def problem(name, folder):
    """Scene, end, output, and the runs of peers: functions of a step count or tolerance, by tool."""
    if name in CHAINS:
        end = CHAINS[name]
        part, superelement, centres = chain_scene.write_component(mechanisms.BINARIES, folder, CHAIN)
        scene = chain_scene.scene(CHAIN, superelement, centres, 1e-4, 1000)

        def exudyn(steps):
            found = runner.exudyn(folder, part, superelement, CHAIN, end / steps, steps, "modified")
            return dict(seconds=found["seconds"], steps=steps, version="Exudyn " + found["version"], every=RECORDS // chain_scene.RECORDS,
                        deflection=np.array(found["position"]))

        return scene, end, "tip", {"exudyn": (exudyn, PEER_STEPS[:1])}
    made = mechanisms.PROBLEMS[name]
    part, scene, end, peer = made["make"](folder)
    superelement = mechanisms.reduce(part, os.path.join(folder, "part.dcb.h5"), MODES[name])
    scene["bodies"]["body"]["superelement"] = superelement
    peers = {}
    if peer:

        def exudyn(steps):
            found = mechanisms.run_exudyn(folder, part, superelement, peer, end / steps, end, scene)
            return dict(seconds=found["seconds"], steps=found["steps"], version="Exudyn " + found["version"], deflection=found["deflection"])

        peers["exudyn"] = (exudyn, PEER_STEPS)
    if name == "spinning-plate":

        def equations(tool):
            def run(tolerance):
                job, result = os.path.join(folder, "job.json"), os.path.join(folder, "result.json")
                with open(job, "w") as file:
                    json.dump(dict(superelement=superelement, tool=tool, tolerance=tolerance, end=end, records=RECORDS, deflection=1e-6,
                                   angular_velocity=scene["bodies"]["body"]["angular_velocity"], node=peer["node"]), file)
                runner.run([sys.executable, os.path.join(runner.HERE, "peers", "free_body.py"), job, result])
                with open(result) as file:
                    found = json.load(file)
                if not found["solved"]:
                    sys.exit(f"{tool} failed")
                return dict(found, deflection=np.array(found["deflection"]))

            return run

        for tool in ("scipy-radau", "ida"):
            peers[tool] = (equations(tool), [1e-3, 1e-5, 1e-7])
    return scene, end, "deflection", peers


def error(found, reference, every=1):
    reference = reference[::every]
    width = min(found.shape[1], reference.shape[1])
    distance = np.linalg.norm(found[:, :width] - reference[: len(found), :width], axis=1)
    return float(distance.max() / np.linalg.norm(reference[:, :width] - reference[:1, :width], axis=1).max())


def force_error(found, reference):
    return float(np.linalg.norm(found - reference, axis=1).max() / np.linalg.norm(reference, axis=1).max())


def study(name, rounds, peers, folder):
    scene, end, output, others = problem(name, folder)
    if name in JOINTS:
        scene["outputs"]["force"] = {"reaction": {"joint": JOINTS[name]}}
    best = simulate(folder, scene, {"radau": {"tolerance": 1e-11, "end": end, "order": 9}}, end, output)
    other = simulate(folder, scene, {"radau": {"tolerance": 1e-10, "end": end, "order": 5}}, end, output)
    reference = best["deflection"]
    forces = {} if best["force"] is None else dict(force_uncertainty=force_error(other["force"], best["force"]))
    yield dict(kind="reference", problem=name, steps=best["steps"], uncertainty=error(other["deflection"], reference), end=end, **forces)
    runs = {("radau9", tolerance): {"radau": {"tolerance": tolerance, "end": end, "order": 9}} for tolerance in TOLERANCES}
    runs |= {("radau5", tolerance): {"radau": {"tolerance": tolerance, "end": end, "order": 5}} for tolerance in TOLERANCES}
    if name in JOINTS:
        runs |= {("radau9-forces", tolerance): {"radau": {"tolerance": 1e-2, "force_tolerance": tolerance, "end": end}} for tolerance in FORCE_TOLERANCES}
    runs |= {("generalized-alpha", steps): {"generalized_alpha": {"step": end / steps, "end": end, "rho_infinity": RHO}} for steps in [*STEPS, *FURTHER_STEPS.get(name, [])]}
    runs |= {(tool, setting): None for tool, (_, settings) in (others.items() if peers else ()) for setting in settings}
    times, last = {}, {}
    for _ in range(rounds):
        for run in random.sample(list(runs), len(runs)):
            tool, setting = run
            for _ in range(REPEATED):
                found = others[tool][0](setting) if runs[run] is None else simulate(folder, scene, runs[run], end, output)
                times.setdefault(run, []).append(found["seconds"])
                last[run] = found
                if found["seconds"] > SHORT:
                    break
    for (tool, setting), found in last.items():
        expected, moved = reference, found["deflection"]
        if tool == "exudyn" and "slider" in name:
            moved, expected = mechanisms.in_plane(moved), mechanisms.in_plane(expected)
        forces = {} if found.get("force") is None else dict(force_error=force_error(found["force"], best["force"]))
        yield dict(
            kind="run", problem=name, tool=tool, setting=setting, **forces, seconds=min(times[tool, setting]), all_seconds=times[tool, setting],
            error=error(moved, expected, found.get("every", 1)), **{k: found[k] for k in ("steps", "newton_iterations", "jacobian_updates", "evaluations", "version") if k in found},
        )


NAMES = {"radau9": "`radau`, order 9", "radau5": "`radau`, order 5", "generalized-alpha": "`generalized_alpha`", "exudyn": "Exudyn",
         "scipy-radau": "SciPy Radau", "ida": "SUNDIALS IDA"}


def seconds_at(runs, wanted):
    """Time at an error, from the two runs around it by a straight line of logarithms; `None` where no run is as good."""
    points = sorted((run["error"], run["seconds"]) for run in runs)
    best = min((seconds for error, seconds in points if error <= wanted), default=None)
    for (e1, t1), (e2, t2) in zip(points, points[1:]):
        if e1 <= wanted <= e2 and e2 > e1:
            x = np.log(wanted / e1) / np.log(e2 / e1)
            at = float(np.exp((1 - x) * np.log(t1) + x * np.log(t2)))
            best = at if best is None else min(best, at)
    return best


def forces_table(lines):
    """What a tolerance of the motion and one of forces make of the forces of a joint."""
    text = ["### Forces", "", "Force of the joint at the flexible body, largest error over the recorded times by the largest force, order 9. A stiff rod rings along itself by a millionth of its length: the motion's tolerance "
            "doesn't see it, the force is made of it. `force_tolerance` holds it, and with it the motion.", "",
            "| mechanism | tolerance | with `tolerance`: error of deflection | of force | s | with `force_tolerance`: error of deflection | of force | s |", "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for name in JOINTS:
        own = {(run["tool"], run["setting"]): run for run in lines if run["kind"] == "run" and run["problem"] == name}
        for tolerance in FORCE_TOLERANCES:
            cells = []
            for tool in ("radau9", "radau9-forces"):
                run = own[tool, tolerance]
                cells += [f"{run['error']:.1e}", f"{run['force_error']:.1e}", digits(run["seconds"])]
            text.append(f"| {name} | {tolerance:.0e} | {' | '.join(cells)} |")
    uncertain = [f"{line['problem']} {line['force_uncertainty']:.0e}" for line in lines if line["kind"] == "reference" and "force_uncertainty" in line]
    worst = {name: min(run["force_error"] for run in lines if run["kind"] == "run" and run["problem"] == name and run["tool"] == "generalized-alpha") for name in JOINTS}
    return [*text, "", "`generalized_alpha` at its best step here: " + ", ".join(f"{name} {error:.0e}" for name, error in worst.items())
            + ". How far forces of the two references differ: " + ", ".join(uncertain) + ".", ""]


def digits(value):
    return "–" if value is None else f"{value:.3g}"


def render(lines):
    import matplotlib

    matplotlib.use("svg")
    import matplotlib.pyplot as plt

    matplotlib.rcParams["svg.hashsalt"] = "work-precision"
    about = lines[0]
    versions = sorted({line["version"] for line in lines if line.get("version")})
    text = [BEGIN, f"`{about['command']}` at commit {about['commit']}, {about['machine']['cpu']}, {about['machine']['cores']} cores, "
            f"Python {about['machine']['python']}; ρ∞ = {RHO}. {', '.join(versions)}.", ""]
    problems = list(dict.fromkeys(line["problem"] for line in lines))
    text += ["Seconds of integration for an error of the motion, between the measured runs by straight lines of the logarithms, and how many times as long "
             "`generalized_alpha` takes as the faster of the two orders. –: no run was as good.", "",
             "| mechanism | error | `radau`, order 9 | `radau`, order 5 | `generalized_alpha` | times | Exudyn | SciPy Radau | SUNDIALS IDA |",
             "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    for name in problems:
        own = [line for line in lines if line["kind"] == "run" and line["problem"] == name]
        for wanted in WANTED:
            at = {tool: seconds_at([run for run in own if run["tool"] == tool], wanted) for tool in NAMES}
            ours = [at[tool] for tool in ("radau9", "radau5") if at[tool]]
            ratio = at["generalized-alpha"] / min(ours) if ours and at["generalized-alpha"] else None
            ran = {run["tool"] for run in own}
            cells = [digits(at[tool]) if tool in ran else "not run" for tool in NAMES]
            text.append(f"| {name} | {wanted:.0e} | {cells[0]} | {cells[1]} | {cells[2]} | {digits(ratio)} | {cells[3]} | {cells[4]} | {cells[5]} |")
    text += ["", "What was wanted of `radau` beside `generalized_alpha`: 3 times as fast for an error of 1e-4, 7 times for 1e-6. Where `generalized_alpha` reaches no such error, "
             "the ratio is at least that for its best run.", "",
             "| mechanism | 1e-4, wanted ≥ 3 | | 1e-6, wanted ≥ 7 | |", "| --- | --- | --- | --- | --- |"]
    for name in problems:
        own = [line for line in lines if line["kind"] == "run" and line["problem"] == name]
        cells = []
        for wanted, least in ((1e-4, 3), (1e-6, 7)):
            at = {tool: seconds_at([run for run in own if run["tool"] == tool], wanted) for tool in ("radau9", "radau5", "generalized-alpha")}
            ours = [at[tool] for tool in ("radau9", "radau5") if at[tool]]
            # Its most accurate run takes less than one of this error would.
            best = min((run for run in own if run["tool"] == "generalized-alpha"), key=lambda run: run["error"])
            theirs, sign = (at["generalized-alpha"], "") if at["generalized-alpha"] else (best["seconds"], "> ")
            ratio = theirs / min(ours) if ours else None
            cells += [sign + digits(ratio) if ratio else "–", "–" if ratio is None else "met" if ratio >= least else "not shown" if sign else "**missed**"]
        text.append(f"| {name} | {' | '.join(cells)} |")
    text.append("")
    for name in problems:
        reference = next(line for line in lines if line["kind"] == "reference" and line["problem"] == name)
        figure, axes = plt.subplots(figsize=(6.4, 4.0))
        for tool, marker in zip(NAMES, "osD^vx"):
            runs = sorted((run["seconds"], run["error"]) for run in lines if run["kind"] == "run" and run["problem"] == name and run["tool"] == tool)
            if runs:
                axes.loglog(*zip(*runs), marker=marker, label=NAMES[tool].replace("`", ""))
        axes.set_xlabel("seconds of integration")
        axes.set_ylabel("error of the motion, relative")
        axes.set_title(name)
        axes.set_ylim(1e-10, 2)
        axes.grid(True, which="major", alpha=0.4)
        axes.legend()
        figure.tight_layout()
        path = os.path.join(PICTURES, f"work-precision-{name}.svg")
        figure.savefig(path, metadata={"Date": None})
        plt.close(figure)
        text += [f"![work against precision of {name}](pictures/work-precision-{name}.svg)", "",
                 f"{name}: two references, of order 9 and of order 5, differ by {reference['uncertainty']:.1e}: smaller errors say no more. Simulated: {reference['end']:.4g} s.", ""]
    text += forces_table(lines)
    text.append(END)
    with open(PAGE) as file:
        page = file.read()
    before, after = page[: page.index(BEGIN)], page[page.index(END) + len(END):]
    with open(PAGE, "w") as file:
        file.write(before + "\n".join(text) + after)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--problems", default=",".join([*MODES, *CHAINS]))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--without-peers", action="store_true")
    parser.add_argument("--render", action="store_true")
    arguments = parser.parse_args()
    if not arguments.render:
        about = dict(runner.conditions(), command="python3 tests/benches/work_precision.py " + " ".join(sys.argv[1:]))
        lines = []
        for name in arguments.problems.split(","):
            with tempfile.TemporaryDirectory() as folder:
                for line in study(name, arguments.rounds, not arguments.without_peers, folder):
                    lines.append(dict(line, **about))
                    shown = {k: v for k, v in line.items() if k != "all_seconds"}
                    print(json.dumps(shown), flush=True)
        if not arguments.write:
            return
        with open(DATA, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)
    with open(DATA) as file:
        render([json.loads(line) for line in file])


if __name__ == "__main__":
    main()
