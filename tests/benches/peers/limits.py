"""What the machine can do at most: dgemm (NumPy's OpenBLAS, the system's, MKL) and triad bandwidth, as JSON lines.

    python3 limits.py [--threads 1,2]

A line has the best and the median of seven. Bandwidth counts 5 x 8 bytes an entry: a = 3 c, then a = a + b.
"""
import argparse
import ctypes
import ctypes.util
import json
import os
import subprocess
import sys
import threading
import time

ORDER, ENTRIES, REPEATS = 2048, 40_000_000, 7


def measure(work):
    """Best and median seconds."""
    work()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times), sorted(times)[REPEATS // 2]


def dgemm(library):
    import numpy as np

    a = np.asfortranarray(np.random.default_rng(0).random((ORDER, ORDER)))
    b, c = a.copy(order="F"), np.zeros_like(a)
    if library == "numpy":
        return lambda: np.matmul(a.T, b.T, out=c.T)
    if library == "mkl":
        import pypardiso

        blas = pypardiso.PyPardisoSolver().libmkl
    else:
        blas = ctypes.CDLL(ctypes.util.find_library("openblas"))

    def integer():
        return ctypes.byref(ctypes.c_int(ORDER))

    def real(value):
        return ctypes.byref(ctypes.c_double(value))

    def array(values):
        return values.ctypes.data_as(ctypes.c_void_p)

    return lambda: blas.dgemm_(
        b"N", b"N", integer(), integer(), integer(), real(1), array(a), integer(), array(b), integer(), real(0), array(c), integer()
    )


def triad(threads):
    import numpy as np

    a, b, c = np.zeros(ENTRIES), np.ones(ENTRIES), np.ones(ENTRIES)

    def part(index):
        rows = slice(index * ENTRIES // threads, (index + 1) * ENTRIES // threads)
        np.multiply(c[rows], 3.0, out=a[rows])
        np.add(a[rows], b[rows], out=a[rows])

    def work():
        workers = [threading.Thread(target=part, args=(index,)) for index in range(threads)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()

    return work


def one(library, threads):
    if library == "triad":
        best, median = measure(triad(threads))
        return dict(limit="bandwidth", library="numpy", threads=threads, best=40e-9 * ENTRIES / best, median=40e-9 * ENTRIES / median, unit="GB/s")
    best, median = measure(dgemm(library))
    flops = 2e-9 * ORDER**3
    return dict(
        limit="dgemm", library=library, core=os.environ.get("OPENBLAS_CORETYPE", ""), threads=threads, best=flops / best,
        median=flops / median, unit="GFLOP/s",
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    counts = [int(count) for count in options.threads.split(",")]
    if options.one:
        print(json.dumps(one(options.one, counts[0])))
        return
    for threads in counts:
        environment = dict(os.environ)
        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
            environment[name] = str(threads)
        plain = {name: value for name, value in environment.items() if name != "OPENBLAS_CORETYPE"}
        for library in ("numpy", "openblas", "mkl", "triad"):
            command = [sys.executable, os.path.abspath(__file__), "--one", library, "--threads", str(threads)]
            for variables in (environment, plain) if library == "openblas" and plain != environment else (environment,):
                print(subprocess.run(command, env=variables, stdout=subprocess.PIPE, text=True).stdout.strip(), flush=True)


if __name__ == "__main__":
    main()
