"""Reading a Matrix Market file of 100 MB and more: this project against fast_matrix_market, interleaved in one run.

    pip install numpy scipy fast_matrix_market
    cargo build --release -p dcb-formats --example read_matrix
    python3 tests/benches/read_matrix.py [--side 64] [--rounds 15] >> docs/data/read_matrix.jsonl

A symmetric 27-point stencil matrix with 17-digit values is written to a temporary folder. Each round times, in random
order, our complete reading (symmetric expansion to compressed columns, symmetry checks, SHA-256), `mmread` (triplets) and
`mmread` + `tocsc` (what a user has to do to get the same). Ratios are ours / theirs within a round, medians over the rounds;
the processor time of all threads is less disturbed by other programs than the clock. One JSON line is printed.
"""

import argparse
import hashlib
import importlib.metadata
import json
import os
import pathlib
import platform
import random
import resource
import statistics
import subprocess
import sys
import tempfile
import time

import fast_matrix_market as fmm
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
READER = REPOSITORY / "target/release/examples/read_matrix"
THREADS = 2


def write_stencil(path, side):
    """Lower triangle of a symmetric 27-point stencil on a cube, column after column, 17 digits."""
    generator = np.random.default_rng(20240602)
    count = side**3
    node = np.arange(count)
    x, y, z = node % side, node // side % side, node // side**2
    rows, columns = [], []
    for dz in (0, 1):
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                if (dz, dy, dx) < (0, 0, 0):
                    continue
                inside = (
                    (x + dx >= 0) & (x + dx < side) & (y + dy >= 0) & (y + dy < side) & (z + dz < side)
                )
                columns.append(node[inside])
                rows.append(node[inside] + dx + side * dy + side**2 * dz)
    rows, columns = np.concatenate(rows), np.concatenate(columns)
    order = np.lexsort((rows, columns))
    rows, columns = rows[order] + 1, columns[order] + 1
    values = np.where(rows == columns, 8e9, -3e8) * (1 + 0.1 * generator.random(rows.size))
    with open(path, "w") as file:
        file.write("%%MatrixMarket matrix coordinate real symmetric\n")
        file.write(f"{count} {count} {rows.size}\n")
        for start in range(0, rows.size, 100_000):
            part = slice(start, start + 100_000)
            lines = zip(rows[part].tolist(), columns[part].tolist(), values[part].tolist())
            file.write("".join(f"{row} {column} {value:.16e}\n" for row, column, value in lines))
    return count, rows.size


def ours(path):
    environment = dict(os.environ, RAYON_NUM_THREADS=str(THREADS))
    used = processor_time(resource.RUSAGE_CHILDREN)
    run = subprocess.run([READER, path, "1"], env=environment, capture_output=True, text=True, check=True)
    return float(run.stdout.split()[0]), processor_time(resource.RUSAGE_CHILDREN) - used


def theirs(path):
    used = processor_time(resource.RUSAGE_SELF)
    start = time.perf_counter()
    triplets = fmm.mmread(path, parallelism=THREADS)
    parsed = time.perf_counter()
    used = processor_time(resource.RUSAGE_SELF) - used
    triplets.tocsc()
    return parsed - start, time.perf_counter() - start, used


def processor_time(who):
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


def same_matrix(path):
    """The number of entries of both readings."""
    run = subprocess.run([READER, path, "1"], capture_output=True, text=True, check=True)
    words = run.stdout.replace(",", "").split()
    digest = hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()
    return int(words[5]) == fmm.mmread(path, parallelism=THREADS).tocsc().nnz and words[7] == digest


def cpu_model():
    for line in open("/proc/cpuinfo"):
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--side", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=15)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = str(pathlib.Path(folder) / "stencil.mtx")
        size, entries = write_stencil(path, arguments.side)
        if not same_matrix(path):
            sys.exit("the two readers disagree")
        rounds = []
        for _ in range(arguments.rounds):
            times = {}
            for name, measure in random.sample([("ours", ours), ("theirs", theirs)], 2):
                times[name] = measure(path)
            rounds.append((*times["ours"], *times["theirs"]))
        megabytes = os.path.getsize(path) / 1e6
    full, full_used, triplets, columns, triplets_used = (statistics.median(times) for times in zip(*rounds))
    print(
        json.dumps(
            {
                "command": "python3 tests/benches/read_matrix.py " + " ".join(sys.argv[1:]),
                "file_mb": round(megabytes, 1),
                "rows": size,
                "stored_entries": entries,
                "threads": THREADS,
                "rounds": arguments.rounds,
                "ours_to_csc_with_sha256_s": round(full, 4),
                "fmm_mmread_s": round(triplets, 4),
                "fmm_mmread_tocsc_s": round(columns, 4),
                "ratio_to_mmread": round(statistics.median(r[0] / r[2] for r in rounds), 3),
                "ratio_to_mmread_worst": round(max(r[0] / r[2] for r in rounds), 3),
                "ratio_to_mmread_tocsc": round(statistics.median(r[0] / r[3] for r in rounds), 3),
                "ours_cpu_s": round(full_used, 4),
                "fmm_mmread_cpu_s": round(triplets_used, 4),
                "ratio_cpu_to_mmread": round(statistics.median(r[1] / r[4] for r in rounds), 3),
                "load_average": round(os.getloadavg()[0], 2),
                "cpu": cpu_model(),
                "python": platform.python_version(),
                "fast_matrix_market": importlib.metadata.version("fast_matrix_market"),
                "numpy": np.__version__,
                "scipy": importlib.metadata.version("scipy"),
            }
        )
    )


if __name__ == "__main__":
    main()
