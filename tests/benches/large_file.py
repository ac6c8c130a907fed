"""What a scene reads of a superelement with 2 GB of nodal fields: time and bytes of whole `simulate` processes, beside the same with a small file.

    pip install numpy h5py
    python3 tests/benches/large_file.py [--nodes 800000] [--rounds 7] [--write]

A connecting rod with 100 modes swings on its big end under gravity, a force at its small end, for 100 steps. `two interfaces` looks at the position of the
small end, `two interfaces and a node` at a node besides. `small` is the file as `reduce` makes it, `large` has the same superelement with the fields of
800 000 nodes; results have to be the same to the last bit. `warm` runs find the file in the system's cache, and the least of all rounds counts; before a
`cold` one the system is told to drop it. Bytes are those that the system says the process has read, whatever it is: libraries too. Needs 5 GB of
memory, and 2.2 GB of disk until it ends.

`--write` puts the lines in place of docs/data/large_file.jsonl; the test `large_file_page` says how docs/format.md shows them.
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

import simulate_against_exudyn as runner

DATA = os.path.join(runner.ROOT, "docs", "data", "large_file.jsonl")
SIMULATE = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(runner.ROOT, "target")), "release", "simulate")
NODE = 2787
OUTPUTS = {
    "two interfaces": {"tip": {"position": {"at": "rod/small-end"}}},
    "two interfaces and a node": {"tip": {"position": {"at": "rod/small-end"}}, "node": {"node_position": {"body": "rod", "node": NODE}}},
}


def scene(superelement, outputs):
    return {
        "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"}, "gravity": [0, -9.81, 0],
        "bodies": {"rod": {"superelement": superelement}},
        "joints": {"hinge": {"revolute": {"a": "ground", "b": "rod/big-end", "axis": [0, 0, 1]}}},
        "loads": {"push": {"force": {"at": "rod/small-end", "components": [0, 10, 0]}}},
        "outputs": outputs,
        "integrator": {"generalized_alpha": {"step": 1e-5, "end": 1e-3, "rho_infinity": 0.8}},
    }


def run(path, results):
    """Seconds and bytes read of one process."""
    command = [SIMULATE, path, "-o", results, "--threads", "1", "--quiet", "--force"]
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    # Ended, but not yet gone: its counters can still be read.
    ended = os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
    seconds = time.perf_counter() - start
    with open(f"/proc/{process.pid}/io") as file:
        counts = dict(line.split(": ") for line in file.read().splitlines())
    process.wait()
    if ended.si_status != 0:
        sys.exit(f"{' '.join(command)} failed with status {ended.si_status}")
    return seconds, int(counts["rchar"])


def forget(path):
    """Tells the system to drop what it keeps of a file."""
    handle = os.open(path, os.O_RDONLY)
    os.fsync(handle)
    os.posix_fadvise(handle, 0, 0, os.POSIX_FADV_DONTNEED)
    os.close(handle)


def outputs(results):
    with h5py.File(results) as file:
        return {name: data[:] for name, data in file["outputs"].items()}


def measure(folder, rounds):
    found, expected = {}, {}
    for round_number in range(rounds):
        for what, wanted in OUTPUTS.items():
            for name in ("small", "large"):
                file, results = os.path.join(folder, f"{name}.dcb.h5"), os.path.join(folder, "results.h5")
                path = os.path.join(folder, "scene.json")
                with open(path, "w") as out:
                    json.dump(scene(f"{name}.dcb.h5", wanted), out)
                for cache in ("cold", "warm"):
                    if cache == "cold":
                        forget(file)
                    seconds, count = run(path, results)
                    key = (what, name, cache)
                    least = min(seconds, found.get(key, (seconds, 0))[0])
                    found[key] = least, count, os.path.getsize(file)
                    now = outputs(results)
                    same = expected.setdefault(what, now)
                    if any(not np.array_equal(same[output], now[output]) for output in same):
                        sys.exit(f"{what}: the {name} file gives other results")
    for (what, name, cache), (seconds, count, size) in found.items():
        yield dict(kind="run", scene=what, file=name, cache=cache, seconds=seconds, bytes_read=count, file_bytes=size, rounds=rounds)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", type=int, default=800000)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    subprocess.check_call(["cargo", "build", "--release", "--quiet", "--bin", "simulate"], cwd=runner.ROOT)
    lines = [dict(kind="conditions", **runner.conditions())]
    lines[0]["command"] = "python3 tests/benches/large_file.py " + " ".join(sys.argv[1:])
    with tempfile.TemporaryDirectory() as folder:
        generate = ["cargo", "run", "--release", "--quiet", "-p", "dcb-tests", "--example", "large_file", "--", folder, str(options.nodes)]
        subprocess.check_call(generate, cwd=runner.ROOT)
        for line in measure(folder, options.rounds):
            lines.append(line)
            print(json.dumps(line), flush=True)
    if options.write:
        with open(DATA, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
