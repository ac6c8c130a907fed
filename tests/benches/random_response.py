"""Random response of a scene from densities against a long motion under a force that has them.

    pip install numpy h5py
    python3 tests/benches/random_response.py [--seconds 60] [--runs 4] [--write [FILE]]

The shipped rotor hangs in two damped bushings. A force at the right bearing has the density 4 N²/Hz from 5 Hz to 150 Hz. `"random"` of a frequency analysis says the root mean square of the
bearing's displacement and how often it crosses zero; runs over time under sums of sines with random phases measure both, the first second left out. One JSON line each;
`--write` puts them into docs/data/random_response.jsonl or FILE; `--example render_pages` renders the page.
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

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.path.join(ROOT, "docs", "data", "random_response.jsonl")
BINARIES = os.path.join(ROOT, "target", "release")
DENSITY, BAND = 4.0, (5.0, 150.0)
STEP = 2.5e-4


def run(program, *arguments, folder):
    start = time.perf_counter()
    done = subprocess.run([os.path.join(BINARIES, program), *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return done.stdout, time.perf_counter() - start


def scene(load, **rest):
    bushing = lambda end, along: {"bushing": {"a": f"ground/{end}", "b": f"rotor/bearing-{end}", "translation": [2e5, 3e5, along], "translation_damping": [800, 800, 60 if along else 0],
                                              **({"rotation": [0, 0, 100]} if along else {})}}
    return {"dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"}, "ground": {"points": {"left": [0, 0, 0], "right": [0, 0, 0.5]}},
            "bodies": {"rotor": {"superelement": "rotor.dcb.h5"}}, "springs": {"left": bushing("left", 1e5), "right": bushing("right", 0)},
            "loads": {"pull": {"force": {"at": "rotor/bearing-right", "components": [load, 0, 0]}}},
            "outputs": {"bearing": {"displacement": {"at": "rotor/bearing-right"}}}, **rest}


def force(rng, seconds):
    """Times and values of a periodic force with this density."""
    count = int(round(seconds / STEP))
    frequencies = np.fft.rfftfreq(count, STEP)
    inside = (frequencies >= BAND[0]) & (frequencies <= BAND[1])
    amplitude = np.where(inside, np.sqrt(2 * DENSITY / seconds), 0.0)
    # What straight lines between the samples take away.
    amplitude = amplitude / np.sinc(frequencies * STEP)**2
    spectrum = amplitude * np.exp(2j * np.pi * rng.random(len(frequencies))) * count / 2
    return np.arange(count) * STEP, np.fft.irfft(spectrum, count)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--write", nargs="?", const=DATA)
    arguments = parser.parse_args()
    lines = []

    def say(**line):
        lines.append(line)
        print(json.dumps(line), flush=True)

    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "")
    say(kind="conditions", command="python3 tests/benches/random_response.py " + " ".join(sys.argv[1:]), commit=git, machine={"cpu": cpu, "cores": os.cpu_count()})
    with tempfile.TemporaryDirectory() as folder:
        run("reduce", os.path.join(ROOT, "samples", "data", "rotor", "rotor.mtx"), "--modes", "10", "-o", "rotor.dcb.h5", "-q", folder=folder)
        analysis = {"frequency_response": {"inputs": ["pull"], "frequencies": {"from": 1, "to": 200, "count": 4000},
                                           "random": {"pull": [[BAND[0], DENSITY], [BAND[1], DENSITY]]}}}
        with open(os.path.join(folder, "random.json"), "w") as file:
            json.dump(scene(1, analysis=analysis), file)
        text, seconds = run("simulate", "random.json", "--force", folder=folder)
        row = next(line.split() for line in text.splitlines() if "bearing.x" in line and " by " not in line)
        told = (float(row[0]), float(row[1]))
        say(kind="densities", rms=told[0], zero_crossings=told[1], seconds=seconds)
        rng = np.random.default_rng(11)
        squares, crossings = [], []
        for number in range(arguments.runs):
            times, values = force(rng, arguments.seconds)
            load = {"table": {"times": times.tolist(), "values": values.tolist()}}
            with open(os.path.join(folder, "motion.json"), "w") as file:
                json.dump(scene(load, integrator={"generalized_alpha": {"step": STEP, "end": float(times[-1])}}), file)
            _, seconds = run("simulate", "motion.json", "--force", "-q", folder=folder)
            with h5py.File(os.path.join(folder, "motion.h5")) as file:
                t, x = file["time"][()], file["outputs/bearing"][()][:, 0]
            x = x[t > 1.0]
            x = x - x.mean()
            squares.append(float(np.mean(x**2)))
            crossings.append(float(np.sum((x[:-1] < 0) & (x[1:] >= 0)) / (t[-1] - 1.0)))
            say(kind="motion", run=number + 1, rms=float(np.sqrt(squares[-1])), zero_crossings=crossings[-1], steps=len(t) - 1, seconds=seconds)
        rms = np.sqrt(np.mean(squares))
        spread = np.std(np.sqrt(squares), ddof=1) / np.sqrt(len(squares)) if len(squares) > 1 else float("nan")
        say(kind="together", rms=float(rms), rms_error=float(told[0] / rms - 1), rms_spread=float(spread / rms), zero_crossings=float(np.mean(crossings)),
            zero_crossings_error=float(told[1] / np.mean(crossings) - 1))
    if arguments.write:
        with open(arguments.write, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
