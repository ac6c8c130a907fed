"""Reading other programs' matrices of about 100 MB: each format against Matrix Market, a copy in memory, and its usual reader in Python.

    pip install "numpy<2" scipy h5py pyyeti pyNastran
    cargo build --release -p dcb-import --example read_matrix_file
    python3 formats/import/benches/read_matrices.py [--rounds 7] [--only dmig,petsc] [--folder FOLDER] >> docs/data/read_matrices.jsonl

A symmetric 27-point stencil (or a dense triangle) is written in each format and, the same matrix, in Matrix Market. Every round reads all files in
random order, each in a process of its own: ours up to the full, sorted matrix, with digest and checks; the Matrix Market file by `reduce`'s reader;
the bytes copied in memory once; the peer up to the matrix that it gives, without its imports. Ratios are medians of the ratios within rounds.
Memory is the most that the process had, over the matrix in full storage at 12 bytes an entry. Files are made once for a folder.
"""

import argparse
import datetime
import importlib.metadata
import json
import os
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile

import matrix_forms as forms
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
READER = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target")) / "release/examples/read_matrix_file"

PEERS = {
    "pyyeti op4": "from pyyeti.nastran import op4\nread = lambda path: op4.read(path, sparse=True)",
    "pyyeti rddmig": "from pyyeti.nastran import rddmig as read",
    "pyNastran dmig": "from pyNastran.bdf.bdf import BDF\ndef read(path):\n m = BDF(debug=None); m.read_bdf(path, punch=True, xref=False); return m.dmig['K'].get_matrix(is_sparse=True)",
    "scipy load_npz": "from scipy.sparse import load_npz\nread = lambda path: load_npz(path).tocsr()",
    "numpy load": "import numpy, scipy.sparse\nread = lambda path: scipy.sparse.csr_matrix(numpy.load(path))",
    "scipy loadmat": "from scipy.io import loadmat as read",
    "scipy hb_read": "from scipy.io import hb_read as read",
    "h5py": "import h5py, scipy.sparse\ndef read(path):\n g = h5py.File(path)['K']; return scipy.sparse.csc_matrix((g['data'][:], g['ir'][:], g['jc'][:]))",
    # As PETSc's own PetscBinaryIO.py does it.
    "numpy fromfile": "import numpy as np, scipy.sparse\ndef read(path):\n f = open(path, 'rb'); _, m, n, k = np.fromfile(f, '>i4', 4); p = np.r_[0, np.cumsum(np.fromfile(f, '>i4', m))]\n"
    " j = np.fromfile(f, '>i4', k).astype('i4'); return scipy.sparse.csr_matrix((np.fromfile(f, '>f8', k).astype('f8'), j, p), (m, n))",
    "scipy mmread": "from scipy.io import mmread as read",
}
# Name, writer, matrix, peer.
TEXT = [
    ("CalculiX .sti", forms.calculix, "stencil", None),
    ("Abaqus MATRIX INPUT", forms.matrix_input, "stencil", None),
    ("Abaqus COORDINATE", forms.abaqus_coordinate, "stencil", None),
    ("Abaqus substructure", forms.substructure, "triangle", None),
    ("Harwell-Boeing, ten a line", forms.harwell_boeing, "stencil", None),
    ("Harwell-Boeing, full", forms.harwell_boeing_full, "stencil", "scipy hb_read"),
    ("Harwell-Boeing, HBMAT", forms.hbmat, "stencil", None),
    ("DMIG punch", forms.dmig, "stencil", None),
    ("DMIG punch of 3 MB", forms.dmig, "small", "pyyeti rddmig"),
    ("DMIG punch of 3 MB, again", forms.dmig, "small", "pyNastran dmig"),
    ("OUTPUT4 ASCII", forms.op4_text, "stencil", "pyyeti op4"),
]
BINARY = [
    ("OUTPUT4 binary, bigmat", forms.op4_binary, "stencil", "pyyeti op4"),
    ("OUTPUT4 binary, dense", forms.op4_dense, "dense", "pyyeti op4"),
    ("npz, csr", forms.npz, "stencil", "scipy load_npz"),
    ("npz, coo", forms.npz_coo, "stencil", "scipy load_npz"),
    ("npz, csr, deflated", forms.npz_deflated, "stencil", "scipy load_npz"),
    ("npy, dense", forms.npy_dense, "dense", "numpy load"),
    ("MATLAB 5", forms.mat5, "stencil", "scipy loadmat"),
    ("MATLAB 5, deflated", forms.mat5_deflated, "stencil", "scipy loadmat"),
    ("MATLAB 7.3", forms.mat73, "stencil", "h5py"),
    ("MATLAB 7.3, deflated", forms.mat73_deflated, "stencil", "h5py"),
    ("PETSc", forms.petsc, "stencil", "numpy fromfile"),
]
KINDS = {name: kind for kind, cases in (("text", TEXT), ("binary", BINARY)) for name, *_ in cases}


def triangle(size):
    """A dense lower triangle, column after column."""
    columns, rows = np.triu_indices(size)
    return size, rows, columns, np.random.default_rng(1).standard_normal(rows.size) * 1e6 + 1e8 * (rows == columns)


def row_after_row(size, rows, columns, values):
    """A dense triangle in the order of substructures."""
    order = np.lexsort((columns, rows))
    return size, rows[order], columns[order], values[order]


MATRICES = {
    "stencil": lambda: (60**3, *forms.stencil(60)),
    "small": lambda: (16**3, *forms.stencil(16)),
    "dense": lambda: triangle(3500),
    "triangle": lambda: triangle(2901),
}


def made(folder, name, write, matrix):
    path = folder / f"{name} {matrix}".replace(" ", "_").replace("/", "_")
    if write in (forms.npz, forms.npz_coo, forms.npz_deflated):
        path = path.with_suffix(".npz")
    if write is forms.npy_dense:
        path = path.with_suffix(".npy")
    if not path.exists():
        content = MATRICES[matrix]()
        write(path, *(row_after_row(*content) if write is forms.substructure else content))
    return path


def ours(mode, path):
    return json.loads(subprocess.run([READER, mode, path], capture_output=True, check=True).stdout)


def peer(name, path):
    code = f"import sys, time\n{PEERS[name]}\nstart = time.perf_counter(); m = read(sys.argv[1]); print(time.perf_counter() - start)"
    run = subprocess.run([sys.executable, "-W", "ignore", "-c", code, path], capture_output=True, text=True)
    return float(run.stdout.split()[-1]) if run.returncode == 0 else None


def conditions(rounds):
    models = [line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    told = lambda *command: subprocess.run(command, capture_output=True, text=True, cwd=REPOSITORY).stdout.strip()
    versions = {name: importlib.metadata.version(name) for name in ("numpy", "scipy", "h5py", "pyyeti", "pyNastran")}
    return {
        "kind": "conditions", "command": f"python3 formats/import/benches/read_matrices.py --rounds {rounds}", "commit": told("git", "rev-parse", "--short", "HEAD"), "date": datetime.date.today().isoformat(),
        "cpu": models[0], "cores": os.cpu_count(), "rustc": told("rustc", "--version"), "python": sys.version.split()[0], **versions,
    }


def summary(case, rounds, folder):
    name, write, matrix, with_peer = case
    path, market = made(folder, name, write, matrix), made(folder, "market", forms.matrix_market, matrix)
    size, market_size = path.stat().st_size / 1e6, market.stat().st_size / 1e6
    own = [each["ours", path] for each in rounds]
    middle = lambda key: statistics.median(run[key] for run in own)
    # The system counts processor time in hundredths.
    ratio = lambda other, key, of: statistics.median(each["ours", path][key] / max(each[other, of][key], 0.01) for each in rounds)
    full = 12 * middle("entries")
    line = {"kind": KINDS[name], "format": name, "file_mb": round(size, 1), "rows": int(middle("rows")), "entries": int(middle("entries"))}
    line |= {"read_s": round(middle("read_s"), 3), "whole_s": round(middle("whole_s"), 3), "processor_s": round(middle("processor_s"), 2), "mb_per_s": round(size / middle("whole_s"))}
    to_market = ratio("matrix_market", "whole_s", market)
    line |= {"market_mb": round(market_size, 1), "time_to_market": round(to_market, 2), "time_per_mb_to_market": round(to_market * market_size / size, 2), "processor_to_market": round(ratio("matrix_market", "processor_s", market), 2)}
    line |= {"time_to_copy": round(ratio("copy", "whole_s", path), 2), "processor_to_copy": round(ratio("copy", "processor_s", path), 2)}
    line |= {"read_memory": round(max(run["read_peak"] for run in own) / full, 2), "whole_memory": round(max(run["whole_peak"] for run in own) / full, 2)}
    if with_peer:
        times = [each[with_peer, path] for each in rounds]
        known = None not in times
        line |= {"peer": with_peer, "peer_s": round(statistics.median(times), 3) if known else None}
        line |= {"peer_to_ours": round(statistics.median(t / run["whole_s"] for t, run in zip(times, own)), 2) if known else None}
    return line | {"rounds": len(rounds), "load": round(os.getloadavg()[0], 2)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", help="parts of names, with commas")
    parser.add_argument("--folder")
    options = parser.parse_args()
    wanted = lambda name: not options.only or any(part.lower() in name.lower() for part in options.only.split(","))
    cases = [case for case in TEXT + BINARY if wanted(case[0])]
    with tempfile.TemporaryDirectory() as made_here:
        folder = pathlib.Path(options.folder or made_here)
        folder.mkdir(exist_ok=True)
        jobs = set()
        for name, write, matrix, with_peer in cases:
            path, market = made(folder, name, write, matrix), made(folder, "market", forms.matrix_market, matrix)
            jobs |= {("ours", path), ("copy", path), ("matrix_market", market), ("scipy mmread", market)} | ({(with_peer, path)} if with_peer else set())
        rounds = []
        for _ in range(options.rounds):
            order = random.sample(sorted(jobs), len(jobs))
            rounds.append({job: peer(*job) if job[0] in PEERS else ours(*job) for job in order})
        print(json.dumps(conditions(options.rounds)))
        for case in cases:
            print(json.dumps(summary(case, rounds, folder)), flush=True)
        for matrix in sorted({case[2] for case in cases}):
            market = made(folder, "market", forms.matrix_market, matrix)
            own, theirs = (statistics.median(each[job, market]["whole_s"] if job == "matrix_market" else each[job, market] for each in rounds) for job in ("matrix_market", "scipy mmread"))
            line = {"kind": "market", "matrix": matrix, "file_mb": round(market.stat().st_size / 1e6, 1), "whole_s": round(own, 3), "scipy_mmread_s": round(theirs, 3)}
            print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
