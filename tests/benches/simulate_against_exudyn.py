"""Chains of flexible bodies in `simulate` and in Exudyn: time per step, iterations and answers, interleaved, in the same reduced space.

    pip install exudyn numpy scipy h5py
    cargo build --release -p dcb-programs -p dcb-samples
    python3 tests/benches/simulate_against_exudyn.py [--cases 1x16,4x16] [--rounds 3] [--write]

Each body is the generated connecting rod, reduced by `reduce`. Exudyn gets the same matrices and the same basis (see `exudyn_chain.py`), so
both integrate the same number of coordinates, with the same method, step, damping and interfaces. Timed is the time loop alone, on one
thread, without output files. A table is printed; `--write` puts the raw lines, one per run, in place of docs/data/simulate_against_exudyn.jsonl.
`--peer-only` runs Exudyn alone.
"""
import argparse
import json
import os
import platform
import random
import subprocess
import sys
import tempfile

import chain_scene
import chain_table

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
DATA = os.path.join(ROOT, "docs", "data", "simulate_against_exudyn.jsonl")
STEP, STEPS, FINER = 1e-4, 1000, 10


def case(bodies, coordinates, interface="8 nodes", soft=False, full=False):
    """One row. `soft`: a ten-thousandth of steel's stiffness, so that deformation is percents of the motion and the step resolves it; such
    a row is for accuracy and has runs with a tenth of the step. `full`: with full Newton, too."""
    kind = "" if interface == "8 nodes" else "-bores"
    return dict(
        name=f"{bodies}x{coordinates}{kind}{'-soft' if soft else ''}", bodies=bodies, coordinates=coordinates, interface=interface,
        stiffness_factor=1e-4 if soft else 1.0, rho_infinity=0.8, finer=[1, FINER] if soft else [1],
        newton=["modified", "eager"] + (["full"] if full else []),
    )


CASES = [
    *(case(1, coordinates, full=coordinates == 16) for coordinates in (8, 16, 32, 64, 128)),
    *(case(bodies, 16, full=bodies in (4, 16)) for bodies in (2, 4, 8, 16, 32, 64)),
    *(case(bodies, 16, interface="bores") for bodies in (1, 4, 16)),
    case(1, 64, interface="bores"),
    *(case(bodies, 16, soft=True) for bodies in (1, 4)),
]


def run(command):
    """Runs a command on one thread; its processor time."""
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", RAYON_NUM_THREADS="1")
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, env=environment)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(command)} failed with status {os.waitstatus_to_exitcode(status)}")
    return usage.ru_utime + usage.ru_stime


def exudyn(folder, part, superelement, one, step, steps, newton):
    job, result = os.path.join(folder, "job.json"), os.path.join(folder, "result.json")
    with open(job, "w") as file:
        json.dump(
            dict(part=part, superelement=superelement, bodies=one["bodies"], step=step, steps=steps, newton=newton,
                 rho_infinity=one["rho_infinity"], gravity=chain_scene.GRAVITY, record_every=steps // chain_scene.RECORDS), file)
    run([sys.executable, os.path.join(HERE, "exudyn_chain.py"), job, result])
    with open(result) as file:
        found = json.load(file)
    if not found["solved"]:
        sys.exit(f"Exudyn failed on {one['name']} with {newton} Newton")
    if max(found["defects"].values()) > 1e-9:
        sys.exit(f"{one['name']}: Exudyn's matrices or interface frames aren't the file's: {found['defects']}")
    if found["coordinates"] != one["coordinates"]:
        sys.exit(f"{one['name']}: the reduction has {found['coordinates']} coordinates")
    return found


def ours(folder, binaries, scene):
    """Runs `simulate`. What it measures itself is the `summary` in the provenance of its results."""
    import h5py

    path, results = os.path.join(folder, "scene.json"), os.path.join(folder, "results.h5")
    with open(path, "w") as file:
        json.dump(scene, file)
    if os.path.exists(results):
        os.remove(results)
    process_seconds = run([os.path.join(binaries, "simulate"), path, "-o", results, "--threads", "1", "--quiet"])
    with h5py.File(results) as file:
        summary = json.loads(file["provenance"].attrs["summary"])
        return dict(
            seconds=summary["integration_seconds"],
            process_cpu_seconds=process_seconds,
            newton_iterations=summary["newton_iterations"],
            jacobian_updates=summary["jacobian_updates"],
            version=str(file.attrs["generator"]),
            time=file["time"][:].tolist(),
            position=file["outputs/tip"][:].tolist(),
        )


def conditions():
    model = next((l.split(":")[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), platform.machine())
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    return dict(
        command="python3 tests/benches/simulate_against_exudyn.py " + " ".join(sys.argv[1:]), commit=commit,
        machine=dict(cpu=model, cores=os.cpu_count(), python=platform.python_version()),
    )


def measure(one, binaries, rounds, peer_only):
    """All runs of one case, in random order within a round; runs with a finer step once."""
    with tempfile.TemporaryDirectory() as folder:
        part, superelement, centres = chain_scene.write_component(binaries, folder, one)
        for finer in one["finer"]:
            step, steps = STEP / finer, STEPS * finer
            scene = chain_scene.scene(one, superelement, centres, step, steps)
            tools = [("exudyn", newton) for newton in one["newton"]] + ([] if peer_only else [("simulate", "")])
            for round_number in range(rounds if finer == 1 else 1):
                for tool, newton in random.sample(tools, len(tools)):
                    load = os.getloadavg()[0]
                    if tool == "exudyn":
                        found = exudyn(folder, part, superelement, one, step, steps, newton)
                    else:
                        found = ours(folder, binaries, scene)
                    yield dict(
                        case=one["name"], bodies=one["bodies"], interface=one["interface"],
                        stiffness_factor=one["stiffness_factor"], rho_infinity=one["rho_infinity"], damping_ratio=chain_scene.DAMPING_RATIO,
                        step=step, steps=steps, tool=tool, newton=newton, round=round_number, load=round(load, 2),
                        coordinates=one["coordinates"], **{k: v for k, v in found.items() if k != "coordinates"}, **conditions(),
                    )


def main():
    names = [one["name"] for one in CASES]
    parser = argparse.ArgumentParser(epilog="Cases: " + ", ".join(names))
    parser.add_argument("--cases", default=",".join(names))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--binaries", default=os.path.join(ROOT, "target", "release"))
    parser.add_argument("--peer-only", action="store_true")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    chosen = options.cases.split(",")
    unknown = [name for name in chosen if name not in names]
    if unknown:
        parser.error(f"no case {', '.join(unknown)}; there are {', '.join(names)}")
    runs = []
    if options.write:
        open(DATA, "w").close()
    for one in (one for one in CASES if one["name"] in chosen):
        for found in measure(one, options.binaries, options.rounds, options.peer_only):
            runs.append(found)
            print(f"{found['case']:14} {found['tool']:9} {found['newton']:9} {found['seconds'] / found['steps'] * 1e6:10.1f} us/step",
                  file=sys.stderr)
            if options.write:
                with open(DATA, "a") as file:
                    file.write(json.dumps(found) + "\n")
    print("\n".join(chain_table.speed(runs)))
    print()
    print("\n".join(chain_table.accuracy(runs)))


if __name__ == "__main__":
    main()
