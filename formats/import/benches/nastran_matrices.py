"""Reading Nastran's matrices of 100 MB: OUTPUT4 and DMIG against this project's Matrix Market reader, pyyeti and pyNastran, interleaved in one run.

    pip install "numpy<2" scipy pyyeti pyNastran
    cargo build --release -p dcb-import --example read_text_matrix
    python3 formats/import/benches/nastran_matrices.py [--side 55] [--dense 3500] [--small 16] [--rounds 5] [--folder FOLDER]

A symmetric 27-point stencil is written as OUTPUT4 bigmat, binary and ASCII, and as DMIG punch, a dense matrix as dense OUTPUT4, each beside the same
matrix in Matrix Market. Every round reads all files in random order, ours each in a process of its own, up to the full, sorted matrix with its digest.
pyNastran and pyyeti read DMIG of a smaller stencil (`--small`). Memory is the most that the process had, over 12 bytes an entry in full storage.
"""

import argparse
import json
import pathlib
import random
import statistics
import struct
import subprocess
import sys
import tempfile

import numpy as np
from text_matrices import matrix_market, ours, stencil

PEERS = {
    "pyyeti_op4": "from pyyeti.nastran import op4; read = lambda p: op4.read(p, sparse=True)",
    "pyyeti_dmig": "from pyyeti.nastran import rddmig as read",
    "pynastran_dmig": "from pyNastran.bdf.bdf import BDF\ndef read(p):\n    m = BDF(debug=None); m.read_bdf(p, punch=True, xref=False); m.dmig['K'].get_matrix(is_sparse=True)",
}


def full(rows, columns, values):
    """Both triangles, column after column."""
    off = rows != columns
    rows, columns = np.concatenate([rows, columns[off]]), np.concatenate([columns, rows[off]])
    values = np.concatenate([values, values[off]])
    order = np.lexsort((rows, columns))
    return rows[order], columns[order], values[order]


def strings(size, rows, columns, values):
    """Each column with its runs of rows that follow each other: first row (1-based), values."""
    starts = np.searchsorted(columns, np.arange(size + 1))
    for column in range(size):
        own = rows[starts[column] : starts[column + 1]]
        cuts = np.flatnonzero(np.diff(own) != 1) + 1
        bounds = [0, *cuts.tolist(), own.size]
        yield column + 1, [(int(own[a]) + 1, values[starts[column] + a : starts[column] + b]) for a, b in zip(bounds, bounds[1:])]


def op4_binary(path, size, rows, columns, values):
    with open(path, "wb") as file:
        file.write(struct.pack("<5i8si", 24, size, -size, 6, 2, b"KGG     ", 24))
        for column, runs in strings(size, *full(rows, columns, values)):
            words = sum(2 + 2 * run.size for _, run in runs)
            body = b"".join(struct.pack("<2i", 2 * run.size + 1, row) + run.tobytes() for row, run in runs)
            file.write(struct.pack("<4i", 12 + 4 * words, column, 0, words) + body + struct.pack("<i", 12 + 4 * words))
        file.write(struct.pack("<4idi", 20, size + 1, 1, 2, 1.0, 20))


def op4_dense(path, size, rows, columns, values):
    matrix = np.zeros((size, size))
    matrix[rows, columns] = matrix[columns, rows] = values
    with open(path, "wb") as file:
        file.write(struct.pack("<5i8si", 24, size, size, 6, 2, b"KGG     ", 24))
        for column in range(size):
            length = 12 + 8 * size
            file.write(struct.pack("<4i", length, column + 1, 1, 2 * size) + matrix[column].tobytes() + struct.pack("<i", length))
        file.write(struct.pack("<4idi", 20, size + 1, 1, 2, 1.0, 20))


def op4_text(path, size, rows, columns, values):
    with open(path, "w") as file:
        file.write(f"{size:8}{-size:8}       6       2KGG     1P,3E23.16\n")
        for column, runs in strings(size, *full(rows, columns, values)):
            text = [f"{column:8}       0{sum(2 + 2 * run.size for _, run in runs):8}\n"]
            for row, run in runs:
                words = [f"{value:23.16E}" for value in run.tolist()]
                text.append(f"{2 * run.size + 1:8}{row:8}\n")
                text.extend("".join(words[at : at + 3]) + "\n" for at in range(0, len(words), 3))
            file.write("".join(text))
        file.write(f"{size + 1:8}       1       1\n 1.0000000000000000E+00\n")


def dmig(path, size, rows, columns, values):
    """As Nastran punches it: one head a column, one entry a line."""
    with open(path, "w") as file:
        file.write("DMIG    K              0       6       2       0\n")
        starts = np.searchsorted(columns, np.arange(size + 1))
        for column in range(size):
            text = [f"DMIG*   K       {column // 3 + 1:16}{column % 3 + 1:16}\n"]
            part = slice(starts[column], starts[column + 1])
            for row, value in zip(rows[part].tolist(), values[part].tolist()):
                text.append(f"*       {row // 3 + 1:16}{row % 3 + 1:16}{f'{value:16.9E}'.replace('E', 'D')}\n")
            file.write("".join(text))


def peer(name, path):
    code = f"import sys, time\n{PEERS[name]}\nt = time.perf_counter(); read(sys.argv[1]); print(time.perf_counter() - t)"
    run = subprocess.run([sys.executable, "-W", "ignore", "-c", code, path], capture_output=True, text=True, check=True)
    return [float(run.stdout.split()[-1])]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--side", type=int, default=55)
    parser.add_argument("--dense", type=int, default=3500)
    parser.add_argument("--small", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--folder")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as made_here:
        folder = pathlib.Path(arguments.folder or made_here)
        folder.mkdir(exist_ok=True)
        lower = np.tril_indices(arguments.dense)
        order = np.lexsort(lower)
        triangle = (lower[0][order], lower[1][order], np.random.default_rng(1).standard_normal(order.size))
        sides = {"large": (arguments.side**3, *stencil(arguments.side)), "small": (arguments.small**3, *stencil(arguments.small)), "dense": (arguments.dense, *triangle)}
        made = [("op4_binary", "op4_binary", op4_binary, "large", ["pyyeti_op4"]), ("op4_dense", "op4_binary", op4_dense, "dense", ["pyyeti_op4"])]
        made += [("op4_text", "op4_text", op4_text, "large", ["pyyeti_op4"]), ("dmig", "dmig", dmig, "large", []), ("dmig_small", "dmig", dmig, "small", ["pyyeti_dmig", "pynastran_dmig"])]
        jobs = []
        for name, kind, write, side, peers in made:
            if not (folder / name).exists():
                write(folder / name, *sides[side])
            jobs += [(kind, folder / name)] + [(one, folder / name) for one in peers]
        for side, matrix in sides.items():
            if not (folder / f"{side}.mtx").exists():
                matrix_market(folder / f"{side}.mtx", *matrix)
            jobs.append(("matrix_market", folder / f"{side}.mtx"))
        rounds = []
        for _ in range(arguments.rounds):
            rounds.append({job: peer(*job) if job[0] in PEERS else ours(*job) for job in random.sample(jobs, len(jobs))})
        for name, kind, _, side, peers in made:
            times = [[each[kind, folder / name] for each in rounds], [each["matrix_market", folder / f"{side}.mtx"] for each in rounds]]
            read, whole, read_peak, whole_peak, rows, entries = map(statistics.median, zip(*times[0]))
            market = statistics.median(one[0] for one in times[1])
            size, other = ((folder / file).stat().st_size / 1e6 for file in (name, f"{side}.mtx"))
            full_kb = 12 * entries / 1024
            line = {"format": name, "file_mb": round(size, 1), "rows": rows, "entries_full": entries, "read_s": round(read, 3), "to_full_matrix_s": round(whole, 3)}
            line |= {"mb_per_s": round(size / whole), "matrix_market_mb": round(other, 1), "matrix_market_s": round(market, 3), "matrix_market_mb_per_s": round(other / market)}
            line |= {"read_memory": round(read_peak / full_kb, 2), "whole_memory": round(whole_peak / full_kb, 2)}
            line |= {f"{one}_s": round(statistics.median(each[one, folder / name][0] for each in rounds), 3) for one in peers}
            print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
