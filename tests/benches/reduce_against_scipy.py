"""Reduction against SciPy (eigsh, shift-invert, SuperLU) on the same part, interleaved, one JSON line per run and a summary.

    python3 tests/benches/reduce_against_scipy.py [--refinement 2] [--modes 30] [--rounds 3] [--threads 1,2] >> docs/data/reduce_against_scipy.jsonl

Needs numpy, scipy, h5py and fast_matrix_market; builds the binaries if they aren't there. Times are of whole processes, from start to
exit, with reading and writing; memory is the largest resident set. The check of our file uses its arrays and SciPy's matrices.
"""
import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BIN = os.path.join(ROOT, "target", "release")


def run(command, threads):
    environment = dict(os.environ)
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        environment[name] = str(threads)
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, env=environment)
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    if status != 0:
        sys.exit(f"{command[0]} failed with status {status}")
    return dict(wall=round(wall, 3), cpu=round(usage.ru_utime + usage.ru_stime, 3), peak_mb=round(usage.ru_maxrss / 1024))


def check(part, superelement):
    """Residuals of our file, computed with SciPy's matrices."""
    import fast_matrix_market as fmm
    import h5py
    import numpy as np

    stem = part.removesuffix(".mtx")
    stiffness, mass = fmm.mmread(part).tocsc(), fmm.mmread(stem + ".mass.mtx").tocsc()
    with h5py.File(superelement) as file:
        shapes, values = file["modes/shapes"][:].T, file["modes/eigenvalues"][:]
        columns, flexibility = file["residual/shapes"][:].T, file["residual/flexibility"][:]
        residual_mass = file["residual/mass"][:]
    forces = stiffness @ shapes
    defects = np.linalg.norm(forces - (mass @ shapes) * values, axis=0) / np.linalg.norm(forces, axis=0)
    return dict(
        frequencies=(np.sqrt(values) / 2 / np.pi).tolist(),
        mode_residual=float(defects.max()),
        orthonormality=float(np.abs(shapes.T @ (mass @ shapes) - np.eye(len(values))).max()),
        flexibility=flexibility.tolist(),
        residual_mass=residual_mass.tolist(),
        flexibility_identity=float(
            np.abs(columns.T @ (stiffness @ columns) - flexibility).max() / np.abs(flexibility).max()
        ),
    )


def machine():
    model = next((l.split(":")[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), platform.machine())
    import numpy
    import scipy

    return dict(
        cpu=model, cores=os.cpu_count(), python=platform.python_version(), numpy=numpy.__version__, scipy=scipy.__version__,
        commit=subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip(),
    )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--refinement", type=int, default=2)
    parser.add_argument("--modes", type=int, default=30)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", default="1,2")
    options = parser.parse_args()
    import numpy as np

    subprocess.check_call(["cargo", "build", "--release", "--quiet", "--bin", "reduce", "--bin", "samples"], cwd=ROOT)
    where = machine()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.check_call(
            [os.path.join(BIN, "samples"), "write", "connecting-rod", "--refinement", str(options.refinement), "--out", folder],
            stdout=subprocess.DEVNULL,
        )
        part = os.path.join(folder, "connecting-rod.mtx")
        for threads in (int(t) for t in options.threads.split(",")):
            walls = {"ours": [], "scipy": []}
            peaks = {"ours": [], "scipy": []}
            for round_number in range(options.rounds):
                ours, theirs = os.path.join(folder, "out.dcb.h5"), os.path.join(folder, "scipy.json")
                timings = os.path.join(folder, "timings.json")
                a = run([os.path.join(BIN, "reduce"), part, "--modes", str(options.modes), "-o", ours, "--force", "--quiet",
                         "--threads", str(threads), "--timings", timings], threads)
                b = run([sys.executable, os.path.join(ROOT, "tests/benches/scipy_reduction.py"), part, str(options.modes), theirs], threads)
                for name, measured in (("ours", a), ("scipy", b)):
                    walls[name].append(measured["wall"])
                    peaks[name].append(measured["peak_mb"])
                found, other = check(part, ours), json.load(open(theirs))
                size = len(found["frequencies"])
                frequency = np.abs(np.array(found["frequencies"]) / np.array(other["frequencies"][:size]) - 1).max()
                flexibility = np.array(found["flexibility"]) - np.array(other["flexibility"])
                stages = {s["stage"]: round(s["seconds"], 3) for s in json.load(open(timings))["stages"]}
                print(json.dumps(dict(
                    kind="run", bench="reduce_against_scipy", threads=threads, round=round_number, refinement=options.refinement,
                    modes=options.modes, load=os.getloadavg()[0], ours=dict(**a, stages=stages,
                        **{k: found[k] for k in ("mode_residual", "orthonormality", "flexibility_identity")}),
                    scipy=dict(**b, stages={k: round(v, 3) for k, v in other["stages"].items()},
                        **{k: other[k] for k in ("mode_residual", "orthonormality", "attachment_residual")}),
                    frequency_difference=float(frequency),
                    flexibility_difference=float(np.abs(flexibility).max() / np.abs(np.array(other["flexibility"])).max()),
                    machine=where,
                )), flush=True)
            ratios = sorted(s / o for o, s in zip(walls["ours"], walls["scipy"]))
            print(json.dumps(dict(
                kind="summary", bench="reduce_against_scipy", threads=threads, refinement=options.refinement, modes=options.modes,
                wall_ours=sorted(walls["ours"])[len(ratios) // 2], wall_scipy=sorted(walls["scipy"])[len(ratios) // 2],
                speedup_median=round(ratios[len(ratios) // 2], 2), speedup_min=round(ratios[0], 2), speedup_max=round(ratios[-1], 2),
                peak_mb_ours=max(peaks["ours"]), peak_mb_scipy=max(peaks["scipy"]), machine=where,
            )), flush=True)


if __name__ == "__main__":
    main()
