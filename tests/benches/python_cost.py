"""What Python adds: a reduction of a large part by the package beside the program, and a step of a mechanism beside the same step inside it.

    pip install numpy scipy ./python
    cargo build --release -p dcb-programs -p dcb-samples
    python3 tests/benches/python_cost.py [--rounds 3] [--write]

The part is the generated block of 162 543 degrees of freedom, 30 modes. Each reduction has a process of its own, program and package by turns. The
program's time is that of its stages without reading and writing files (`--timings`), which the package has not; the package's memory has SciPy's matrices in it.
A step is one of a rigid pendulum, the cheapest there is: a call a step, and one call for all of them. `--write` puts the raw lines in place of docs/data/python_cost.jsonl.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

import python_loop

ROOT = python_loop.ROOT
DATA = os.path.join(ROOT, "docs", "data", "python_cost.jsonl")
MODES = 30
STEPS = 200_000
FILES = ("read", "write")  # stages of the program that the package has not


def reduce_in_python(folder):
    import numpy as np
    import scipy.io
    import tisserand

    stem = os.path.join(folder, "block")
    stiffness, mass = (scipy.io.mmread(stem + end).tocsr() for end in (".mtx", ".mass.mtx"))
    with open(stem + ".json") as file:
        described = json.load(file)
    sets = described["point_sets"]
    interfaces = [dict(name=one["name"], kind=one["kind"], position=one["position"], nodes=sets[one["point_set"]]) for one in described["component"]["interfaces"]]
    points = np.array(described["points"])
    started = time.perf_counter()
    part = tisserand.reduce(stiffness, mass, points, interfaces, modes=MODES)
    seconds = time.perf_counter() - started
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return dict(seconds=seconds, memory=memory, dofs=stiffness.shape[0], frequencies=part.frequencies.tolist())


def reduce_by_program(binaries, folder):
    import tisserand

    timings, target = os.path.join(folder, "timings.json"), os.path.join(folder, "block.dcb.h5")
    command = [os.path.join(binaries, "reduce"), os.path.join(folder, "block.mtx"), "--modes", str(MODES), "-o", target, "--force", "--timings", timings]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    with open(timings) as file:
        stages = {stage["stage"]: stage["seconds"] for stage in json.load(file)["stages"]}
    seconds = sum(seconds for name, seconds in stages.items() if name not in FILES)
    return dict(seconds=seconds, memory=memory, stages=stages, frequencies=tisserand.Superelement.read(target).frequencies.tolist())


def steps():
    import tisserand

    scene = tisserand.Scene(2, gravity=[0, -9.81])
    scene.rigid("bob", mass=1, inertia=0.01, points={"pin": [-0.5, 0]}, position=[0.5, 0])
    scene.revolute("hinge", "ground", "bob/pin")
    scene.integrate(step=1e-4, end=1.0)
    found = {}
    for name, calls in (("calls", STEPS), ("inside", 1)):
        motion = tisserand.Mechanism(scene)
        motion.step(1e-4, 1000)
        started = time.perf_counter()
        for _ in range(calls):
            motion.step(1e-4, STEPS // calls)
        found[name] = (time.perf_counter() - started) / STEPS * 1e9
    return found


def run(job, *arguments):
    with tempfile.NamedTemporaryFile(suffix=".json") as result:
        subprocess.run([sys.executable, __file__, "--job", job, result.name, *arguments], check=True, stdout=subprocess.DEVNULL)
        return json.load(open(result.name))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--binaries", default=os.path.join(ROOT, "target", "release"))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--job", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.job:
        name, result, *arguments = options.job
        jobs = dict(package=reduce_in_python, program=reduce_by_program, steps=steps)
        json.dump(jobs[name](*arguments), open(result, "w"))
        return
    lines = []

    def keep(**line):
        lines.append(dict(**line, load=round(os.getloadavg()[0], 2), **python_loop.conditions("python_cost.py")))
        print(json.dumps(lines[-1]), file=sys.stderr)

    with tempfile.TemporaryDirectory() as folder:
        for number in range(options.rounds):
            found = run("steps")
            keep(kind="step", round=number, nanoseconds_by_calls=found["calls"], nanoseconds_inside=found["inside"])
        samples = os.path.join(options.binaries, "samples")
        subprocess.run([samples, "write", "block", "--refinement", "10", "--stem", "block", "--out", folder], check=True, stdout=subprocess.DEVNULL)
        for number in range(options.rounds):
            program, package = run("program", options.binaries, folder), run("package", folder)
            if program.pop("frequencies") != package.pop("frequencies"):
                sys.exit("the frequencies differ")
            keep(kind="reduction", round=number, dofs=package.pop("dofs"), modes=MODES, program=program, package=package)
    if options.write:
        with open(DATA, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
