"""Whirl of the rotor of example 5.9.1 in Friswell, Penny, Garvey and Lees, "Dynamics of Rotating Machines" (2010): `simulate campbell` beside published values and beside ROSS.

    pip install numpy ross-rotordynamics "plotly<6"
    python3 tests/benches/campbell.py [--write [FILE]]

Published are the values that the documentation of ROSS prints for this example (https://github.com/petrobras/ross, docs/examples/example_05_09_01.rst): six Timoshenko elements with rotary
inertia and gyroscopic moments of the shaft. ROSS is run here with the elements of our shaft: Euler-Bernoulli without rotary inertia. One JSON line each; `--write` puts them into
docs/data/campbell.jsonl or FILE. `--example render_pages` renders the page.
"""
import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.path.join(ROOT, "docs", "data", "campbell.jsonl")
BINARIES = os.path.join(ROOT, "target", "release")
# rad/s at 4000 rev/min, backward and forward in turn.
PUBLISHED = [-85.389467, 87.7958637, -251.78460413, 294.71333087, -600.17936195, 827.07536193]
SPEEDS = (1000, 10000, 10)
SHOWN = [1000, 4000, 8000]
LENGTH, DIAMETER, STIFFNESS, DENSITY = 1.5, 0.05, 1e6, 7810.0


def run(*arguments, folder):
    start = time.perf_counter()
    done = subprocess.run([os.path.join(BINARIES, arguments[0]), *arguments[1:]], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(arguments)}\n{done.stderr}")
    return done.stdout, time.perf_counter() - start


def disk(outer, width=0.07):
    mass = DENSITY * width * np.pi * (outer**2 - DIAMETER**2) / 4
    polar = mass * (outer**2 + DIAMETER**2) / 8
    return mass, polar, polar / 2 + mass * width**2 / 12


def scene():
    def body(outer, place):
        mass, polar, diametral = disk(outer)
        return {"rigid": {"mass": mass, "inertia": [polar, diametral, diametral], "points": {"hub": [0, 0, 0]}}, "position": [place, 0, 0], "angular_velocity": [100, 0, 0]}

    def bearing(end, axial):
        return {"bushing": {"a": f"ground/{end}", "b": f"shaft/{end}", "translation": [axial, STIFFNESS, STIFFNESS]}}

    return {
        "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
        "ground": {"points": {"left": [0, 0, 0], "right": [LENGTH, 0, 0]}},
        "bodies": {"shaft": {"superelement": "shaft.dcb.h5", "angular_velocity": [100, 0, 0]}, "small": body(0.28, 0.5), "large": body(0.35, 1.0)},
        "joints": {"first": {"fixed": {"a": "shaft/disk-1", "b": "small/hub"}}, "second": {"fixed": {"a": "shaft/disk-2", "b": "large/hub"}}},
        "springs": {"left": bearing("left", STIFFNESS), "right": bearing("right", 0)},
        "analysis": {"modes": {"count": 8}},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", nargs="?", const=DATA)
    arguments = parser.parse_args()
    lines = []

    def say(**line):
        lines.append(line)
        print(json.dumps(line), flush=True)

    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "")
    os.chdir(tempfile.gettempdir())                     # what ROSS imports looks for libraries where it is started
    sys.path.insert(0, os.path.join(ROOT, "tests", "data", "whirl"))
    import with_ross

    rotor, _ = with_ross.rotor_of_the_book()
    with tempfile.TemporaryDirectory() as folder:
        run("samples", "write", "shaft", "--out", folder, folder=folder)
        run("reduce", "shaft.mtx", "--modes", "20", "-o", "shaft.dcb.h5", "-q", folder=folder)
        with open(os.path.join(folder, "rotor.json"), "w") as file:
            json.dump(scene(), file)
        text, seconds = run("simulate", "campbell", "rotor.json", "--rpm", ":".join(map(str, SPEEDS)), "--orders", "1,-1", "--modes", "12", "--csv", "whirl.csv", folder=folder)
        with open(os.path.join(folder, "whirl.csv")) as file:
            rows = list(csv.DictReader(file))
    say(kind="conditions", command=("python3 tests/benches/campbell.py " + " ".join(sys.argv[1:])).strip(), commit=git, machine={"cpu": cpu, "cores": os.cpu_count()},
        versions={"ross": with_ross.rs.__version__, "numpy": np.__version__}, seconds=seconds)
    sign = {"forward": 1.0, "backward": -1.0}

    def ours(rpm):
        own = [row for row in rows if abs(float(row["speed [rpm]"]) - rpm) < 1e-6 and row["motion"] in sign]
        return [sign[row["motion"]] * abs(float(row["frequency [Hz]"])) for row in own]

    for place, published in enumerate(PUBLISHED):
        say(kind="published", rpm=4000, mode=place + 1, published=published, ours=2 * np.pi * ours(4000)[place])
    for rpm in SHOWN:
        reference = with_ross.whirl(rotor, rpm * with_ross.RPM)
        for place, found in enumerate(ours(rpm)[:6]):
            say(kind="whirl", rpm=rpm, mode=place + 1, ours=found, ross=reference[place])
    criticals = [line.split()[:3] for line in text.split("critical [rpm]")[1].splitlines()[1:] if line.strip() and line.strip()[0].isdigit()]
    reference = with_ross.criticals(rotor, np.linspace(SPEEDS[0] * 0.5, SPEEDS[1], 30), 4)
    for rpm, _, order in criticals:
        near = [speed for way, speed in reference if way == float(order) and abs(speed / float(rpm) - 1) < 0.01]
        if near:
            say(kind="critical", order=float(order), ours=float(rpm), ross=min(near, key=lambda speed: abs(speed - float(rpm))))
    if arguments.write:
        with open(arguments.write, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
