"""What each kind of damping gives the modes of a double pendulum: two planar rods, hinged to the ground and to each other, hanging.

    pip install h5py
    python3 tests/benches/double_pendulum.py [--write [FILE]]

Each line has a scene's damping and the ratios of its lowest bending modes about the rest. `--write` puts them into docs/data/damping.jsonl or FILE; `--example render_pages` renders the page.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

import h5py

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.path.join(ROOT, "docs", "data", "damping.jsonl")
BINARIES = os.path.join(ROOT, "target", "release")
BENDING = 4     # modes shown, the two swinging ones left out


def run(program, *arguments, folder):
    done = subprocess.run([os.path.join(BINARIES, program), *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)


def scene(length, body=None, whole=None, hinge=None):
    rod = {"superelement": "rod.dcb.h5"}
    if body:
        rod["damping"] = body
    down = -1.5707963267948966
    text = {
        "dimension": 2, "units": {"length": "m", "mass": "kg", "time": "s"}, "gravity": [0, -9.81],
        "bodies": {"upper": dict(rod, orientation=down), "lower": dict(rod, orientation=down, position=[0, -length])},
        "joints": {"top": {"revolute": {"a": "ground", "b": "upper/a"}}, "middle": {"revolute": {"a": "upper/b", "b": "lower/a", "orientation": "body"}}},
        "analysis": {"modes": {"count": 2 + BENDING, "at": "static"}},
    }
    if whole:
        text["damping"] = whole
    if hinge:
        text["springs"] = {"rubbing": {"torsion_spring": {"joint": "middle", "stiffness": 0, "damping": hinge}}}
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", nargs="?", const=DATA)
    arguments = parser.parse_args()
    lines = []

    def say(**line):
        lines.append(line)
        print(json.dumps(line), flush=True)

    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    say(kind="conditions", command="python3 tests/benches/double_pendulum.py " + " ".join(sys.argv[1:]), commit=git)
    with tempfile.TemporaryDirectory() as folder:
        part = os.path.join(ROOT, "samples", "data", "rod", "rod.mtx")
        run("reduce", part, "--modes", "8", "-o", "rod.dcb.h5", "-q", folder=folder)
        with h5py.File(os.path.join(folder, "rod.dcb.h5")) as file:
            ends = file["interfaces/positions"][()]
        length = float(abs(ends[1] - ends[0]).max())

        def modes(**options):
            with open(os.path.join(folder, "scene.json"), "w") as file:
                json.dump(scene(length, **options), file)
            run("simulate", "scene.json", "-o", "scene.h5", "--force", "-q", folder=folder)
            with h5py.File(os.path.join(folder, "scene.h5")) as file:
                return file["modes/frequency"][()].tolist(), file["modes/damping_ratio"][()].tolist()

        frequencies, _ = modes()
        first, last = frequencies[2], frequencies[2 + BENDING - 1]
        through = {"frequencies": [first, last], "ratios": [0.005, 0.005]}
        for name, options in (
            ("modal 0.005 at both rods", {"body": {"modal": 0.005}}),
            ("rayleigh at both rods, 0.005 at the first and the last of these frequencies", {"body": {"rayleigh": through}}),
            ("assembled_modal 0.005", {"whole": {"assembled_modal": 0.005}}),
            ("assembled_rayleigh, 0.005 at the first and the last", {"whole": {"assembled_rayleigh": through}}),
            ("assembled_structural 0.01", {"whole": {"assembled_structural": 0.01}}),
            ("a damper of 0.002 N m s in the middle hinge", {"hinge": 0.002}),
        ):
            hertz, ratios = modes(**options)
            say(kind="damping", of=name, hertz=hertz, ratios=ratios)
    if arguments.write:
        with open(arguments.write, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
