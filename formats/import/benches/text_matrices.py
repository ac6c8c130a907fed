"""Reading text matrices of 100 MB: the formats of other programs against this project's Matrix Market reader and SciPy, interleaved in one run.

    pip install numpy scipy
    cargo build --release -p dcb-import --example read_text_matrix
    python3 formats/import/benches/text_matrices.py [--side 60] [--dense 2900] [--rounds 9] [--folder FOLDER]

A symmetric 27-point stencil with numbers of 16 or 17 digits is written in each format, and a dense triangle as substructure, each beside the same
matrix in Matrix Market. Every round reads all files in random order, each in a process of its own, up to the full, sorted matrix with its digest;
`mmread` of SciPy reads the Matrix Market files to triplets. Ratios are medians of the ratios within rounds. Files are made once for a folder.
"""

import argparse
import json
import os
import pathlib
import random
import statistics
import subprocess
import tempfile
import time

import numpy as np
import scipy.io

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
READER = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target")) / "release/examples/read_text_matrix"


def stencil(side):
    """Lower triangle, column after column: rows, columns, values, all 0-based."""
    generator = np.random.default_rng(20240602)
    node = np.arange(side**3)
    x, y, z = node % side, node // side % side, node // side**2
    rows, columns = [], []
    for dz in (0, 1):
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                if (dz, dy, dx) < (0, 0, 0):
                    continue
                inside = (x + dx >= 0) & (x + dx < side) & (y + dy >= 0) & (y + dy < side) & (z + dz < side)
                columns.append(node[inside])
                rows.append(node[inside] + dx + side * dy + side**2 * dz)
    rows, columns = np.concatenate(rows), np.concatenate(columns)
    order = np.lexsort((rows, columns))
    rows, columns = rows[order], columns[order]
    return rows, columns, np.where(rows == columns, 8e9, -3e8) * (1 + 0.1 * generator.random(rows.size))


def lines(file, spell, *arrays):
    for start in range(0, arrays[0].size, 100_000):
        file.write("".join(map(spell, *(array[start : start + 100_000].tolist() for array in arrays))))


def matrix_market(path, size, rows, columns, values):
    with open(path, "w") as file:
        file.write(f"%%MatrixMarket matrix coordinate real symmetric\n{size} {size} {rows.size}\n")
        lines(file, lambda row, column, value: f"{row} {column} {value:.16e}\n", rows + 1, columns + 1, values)


def calculix(path, size, rows, columns, values):
    with open(path, "w") as file:
        lines(file, lambda row, column, value: f"{column} {row} {value:20.13e}\n", rows + 1, columns + 1, values)


def abaqus_coordinate(path, size, rows, columns, values):
    off = rows != columns
    rows, columns, values = (
        np.concatenate(both) for both in ((rows, columns[off]), (columns, rows[off]), (values, values[off]))
    )
    order = np.lexsort((columns, rows))
    with open(path, "w") as file:
        lines(file, lambda row, column, value: f"{row} {column} {value:.15e}\n", rows[order] + 1, columns[order] + 1, values[order])


def matrix_input(path, size, rows, columns, values):
    labels = rows // 3 + 1, rows % 3 + 1, columns // 3 + 1, columns % 3 + 1
    with open(path, "w") as file:
        lines(file, lambda n, d, m, e, value: f"{n},{d}, {m},{e}, {value:22.15e}\n", *labels, values)


def harwell_boeing(path, size, rows, columns, values, fields=(10, 10, 3), formats="(10I8)          (10I8)          (1P,3E25.16)", letter="E"):
    widths = (8, 8, 25) if fields[0] > 1 else (14, 14, 25)
    digits = 16 if letter == "E" else 15
    starts = np.concatenate(([0], np.cumsum(np.bincount(columns, minlength=size))))
    counts = [-(-count // per) for count, per in zip((size + 1, rows.size, rows.size), fields)]
    with open(path, "w") as file:
        file.write("%-72s%-8s\n" % ("stencil", "KEY") + "".join("%14d" % count for count in (sum(counts), *counts, 0)) + "\n")
        file.write("RSA           " + "".join("%14d" % count for count in (size, size, rows.size, 0)) + f"\n{formats}\n")
        real = lambda value: f"{value:25.{digits}E}".replace("E", letter)  # noqa: E731
        for numbers, per, spell in (
            (starts + 1, fields[0], lambda value: f"{value:{widths[0]}d}"),
            (rows + 1, fields[1], lambda value: f"{value:{widths[1]}d}"),
            (values, fields[2], real),
        ):
            step = 100_000 * per
            for start in range(0, numbers.size, step):
                words = list(map(spell, numbers[start : start + step].tolist()))
                file.writelines("".join(words[at : at + per]) + "\n" for at in range(0, len(words), per))


def hbmat(path, *matrix):
    harwell_boeing(path, *matrix, fields=(1, 1, 1), formats="(1I14)          (1I14)          (1D25.15)", letter="D")


def substructure(path, size, rows, columns, values):
    """`rows` and so on are the whole triangle, row after row."""
    with open(path, "w") as file:
        file.write(f"*USER ELEMENT, NODES={-(-size // 3)}, LINEAR\n** ELEMENT NODES\n")
        file.writelines(f"** {node},\n" for node in range(1, -(-size // 3) + 1))
        file.write(" 1, 2, 3\n*MATRIX,TYPE=STIFFNESS\n")
        for row in range(size):
            first = row * (row + 1) // 2
            words = [f"{value: .14E}" for value in values[first : first + row + 1].tolist()]
            file.writelines(", ".join(words[at : at + 4]) + (",\n" if at + 4 < len(words) else "\n") for at in range(0, len(words), 4))


SPARSE = {
    "calculix": ("coordinate", calculix),
    "abaqus_coordinate": ("coordinate", abaqus_coordinate),
    "matrix_input": ("matrix_input", matrix_input),
    "harwell_boeing": ("harwell_boeing", harwell_boeing),
    "hbmat": ("harwell_boeing", hbmat),
}


def files(folder, side, dense):
    """Name, format and the Matrix Market file of the same matrix."""
    made = []
    matrix = None

    def make(name, write, content):
        path = folder / name
        if not path.exists():
            write(path, *content())
        return path

    def sparse():
        nonlocal matrix
        matrix = matrix or (side**3, *stencil(side))
        return matrix

    def triangle():
        rows, columns = np.tril_indices(dense)
        return dense, rows, columns, np.random.default_rng(1).standard_normal(rows.size) * 1e6 + 1e8 * (rows == columns)

    plain = make(f"stencil_{side}.mtx", matrix_market, sparse)
    for name, (kind, write) in SPARSE.items():
        made.append((name, kind, make(f"{name}_{side}", write, sparse), plain))
    plain = make(f"dense_{dense}.mtx", matrix_market, triangle)
    made.append(("substructure", "substructure", make(f"substructure_{dense}", substructure, triangle), plain))
    return made


def ours(kind, path):
    run = subprocess.run([READER, kind, path], capture_output=True, text=True, check=True)
    words = run.stdout.split()
    return [float(word) for word in words[:2]] + [int(word) for word in words[2:6]]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--side", type=int, default=60)
    parser.add_argument("--dense", type=int, default=2901)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--folder")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as made_here:
        folder = pathlib.Path(arguments.folder or made_here)
        folder.mkdir(exist_ok=True)
        made = files(folder, arguments.side, arguments.dense)
        plain = sorted({path for *_, path in made})
        rounds = []
        for _ in range(arguments.rounds):
            jobs = [(kind, path) for _, kind, path, _ in made] + [("matrix_market", path) for path in plain]
            jobs += [("scipy", path) for path in plain]
            times = {}
            for kind, path in random.sample(jobs, len(jobs)):
                if kind == "scipy":
                    start = time.perf_counter()
                    scipy.io.mmread(path)
                    times["scipy", path] = [time.perf_counter() - start]
                else:
                    times[kind, path] = ours(kind, path)
            rounds.append(times)
    for name, kind, path, mtx in made:
        read, whole, read_peak, _, rows, entries = (statistics.median(column) for column in zip(*(times[kind, path] for times in rounds)))
        market, scipy_seconds = (statistics.median(times[other, mtx][0] for times in rounds) for other in ("matrix_market", "scipy"))
        print(
            json.dumps(
                {
                    "format": name,
                    "file_mb": round(path.stat().st_size / 1e6, 1),
                    "rows": rows,
                    "entries_full": entries,
                    "read_s": round(read, 3),
                    "to_full_matrix_s": round(whole, 3),
                    "mb_per_s": round(path.stat().st_size / 1e6 / whole),
                    "matrix_market_mb": round(mtx.stat().st_size / 1e6, 1),
                    "matrix_market_s": round(market, 3),
                    "scipy_mmread_s": round(scipy_seconds, 3),
                    "ratio_to_matrix_market": round(statistics.median(t[kind, path][1] / t["matrix_market", mtx][1] for t in rounds), 3),
                    "ratio_worst": round(max(t[kind, path][1] / t["matrix_market", mtx][1] for t in rounds), 3),
                    "read_peak_mb": round(read_peak / 1e3, 1),
                    "full_storage_mb": round(entries * 12 / 1e6, 1),
                    "peak_over_full": round(read_peak * 1024 / (entries * 12), 2),
                    "load": round(os.getloadavg()[0], 2),
                }
            )
        )


if __name__ == "__main__":
    main()
