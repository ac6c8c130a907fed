"""Reading binary files of 100 MB with matrices: this project against SciPy, h5py and NumPy, interleaved in one run.

    pip install numpy scipy h5py
    cargo build --release -p dcb-import --example read_binary
    python3 tests/benches/binary_matrices.py [--side 67] [--rounds 9]

A symmetric 27-point stencil matrix in full storage is written to a temporary folder in every form. Each round times, in random order, our
reading (checks and SHA-256 of the file included), reading the bytes and copying them in memory once, and the usual reader in Python (no
checks, no digest). One line a form: the fastest round by the clock, and medians of processor time over all threads, which other programs
disturb less. Ratios are of processor times. `memory` is the most that our process had, over the matrix at 12 bytes an
entry.
"""

import argparse
import json
import pathlib
import random
import resource
import statistics
import subprocess
import tempfile
import time

import h5py
import numpy as np
import scipy.io
import scipy.sparse as sp

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
READER = REPOSITORY / "target/release/examples/read_binary"


def stencil(side):
    generator = np.random.default_rng(20261123)
    band = sp.diags([1.0, 1.0, 1.0], [-1, 0, 1], shape=(side, side))
    pattern = sp.triu(sp.kron(sp.kron(band, band), band)).tocoo()
    values = np.where(pattern.row == pattern.col, 8e9, -3e8) * (1 + 0.1 * generator.random(pattern.nnz))
    upper = sp.csr_matrix((values, (pattern.row, pattern.col)), pattern.shape)
    return (upper + sp.triu(upper, 1).T).tocsr()


def write_all(folder, k, dense):
    """Each form as (name, file, its usual reader)."""
    def path(name):
        return str(folder / name)

    sp.save_npz(path("csr.npz"), k, compressed=False)
    yield "npz, csr", path("csr.npz"), sp.load_npz
    sp.save_npz(path("csr_deflated.npz"), k)
    yield "npz, csr, deflated", path("csr_deflated.npz"), sp.load_npz
    sp.save_npz(path("coo.npz"), k.tocoo(), compressed=False)
    yield "npz, coo", path("coo.npz"), lambda name: sp.load_npz(name).tocsr()
    np.save(path("dense.npy"), dense)
    yield "npy, dense", path("dense.npy"), lambda name: sp.csr_matrix(np.load(name))
    scipy.io.savemat(path("v5.mat"), {"K": k.tocsc()})
    yield "mat 5", path("v5.mat"), scipy.io.loadmat
    scipy.io.savemat(path("v5_compressed.mat"), {"K": k.tocsc()}, do_compression=True)
    yield "mat 5, compressed", path("v5_compressed.mat"), scipy.io.loadmat
    for name, options in (("mat 7.3", {}), ("mat 7.3, deflated", {"chunks": (1 << 16,), "compression": 3})):
        file = path(name.replace(" ", "_") + ".mat")
        with h5py.File(file, "w", userblock_size=512) as f:
            g = f.create_group("K")
            g.attrs["MATLAB_class"], g.attrs["MATLAB_sparse"] = np.bytes_("double"), np.uint64(k.shape[0])
            g.create_dataset("data", data=k.data, **options)
            g.create_dataset("ir", data=k.indices.astype("u8"), **options)
            g.create_dataset("jc", data=k.indptr.astype("u8"))
        with open(file, "r+b") as f:
            f.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
        yield name, file, read_h5py
    with open(path("K.petsc"), "wb") as f:
        np.array([1211216, *k.shape, k.nnz], ">i4").tofile(f)
        np.diff(k.indptr).astype(">i4").tofile(f)
        k.indices.astype(">i4").tofile(f)
        k.data.astype(">f8").tofile(f)
    yield "petsc", path("K.petsc"), read_petsc


def read_h5py(name):
    with h5py.File(name) as f:
        g = f["K"]
        return sp.csc_matrix((g["data"][:], g["ir"][:], g["jc"][:]))


def read_petsc(name):
    """As PETSc's own PetscBinaryIO.py does it."""
    with open(name, "rb") as f:
        _, rows, columns, entries = np.fromfile(f, ">i4", 4)
        starts = np.r_[0, np.cumsum(np.fromfile(f, ">i4", rows))]
        places = np.fromfile(f, ">i4", entries).astype("i4")
        return sp.csr_matrix((np.fromfile(f, ">f8", entries).astype("f8"), places, starts), (rows, columns))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--side", type=int, default=67)
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    k = stencil(options.side)
    size = int(np.sqrt(k.nnz * 1.5))
    dense = np.random.default_rng(1).standard_normal((size, size))
    print(f"{'':20} {'':>5} {'clock, ms':^26} {'processor, ms':^26}")
    print(f"{'form':20} {'MB':>5} " + 2 * f"{'ours':>8} {'copy':>8} {'peer':>8} " + f"{'ours/copy':>9} {'ours/peer':>9} {'memory':>7}")
    with tempfile.TemporaryDirectory() as folder:
        for name, file, peer in write_all(pathlib.Path(folder), k, dense):
            clock = {"read": [], "copy": [], "peer": []}
            processor = {"read": [], "copy": [], "peer": []}
            peak = 0.0
            for _ in range(options.rounds):
                for who in random.sample(list(clock), 3):
                    if who == "peer":
                        start = time.perf_counter(), time.process_time()
                        peer(file)
                        clock[who].append(time.perf_counter() - start[0])
                        processor[who].append(time.process_time() - start[1])
                        continue
                    before = resource.getrusage(resource.RUSAGE_CHILDREN)
                    told = json.loads(subprocess.run([READER, who, file], check=True, capture_output=True).stdout)
                    clock[who].append(told["seconds"])
                    after = resource.getrusage(resource.RUSAGE_CHILDREN)
                    processor[who].append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
                    if who == "read":
                        peak = max(peak, told["peak"] / told["matrices"])
            best = [1e3 * min(clock[who]) for who in clock]
            medians = [1e3 * statistics.median(processor[who]) for who in processor]
            ours, copy, theirs = medians
            row = " ".join(f"{value:8.0f}" for value in best + medians)
            megabytes = pathlib.Path(file).stat().st_size / 1e6
            print(f"{name:20} {megabytes:5.0f} {row} {ours / copy:9.2f} {ours / theirs:9.2f} {peak:7.2f}", flush=True)
            pathlib.Path(file).unlink()


main()
