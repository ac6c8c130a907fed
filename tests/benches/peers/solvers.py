"""Direct solvers of symmetric positive definite systems behind one interface: analyze(A), factor(), solve(B), statistics.

A is a complete symmetric CSR matrix. After `factor` a solver holds what it needs of A itself.
"""
import ctypes
import os
import subprocess
import tempfile

import numpy as np
import scipy.sparse as sp

HERE = os.path.dirname(os.path.abspath(__file__))


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


class SuperLU:
    """SciPy's. It orders inside `splu`, so the ordering is a part of the time of `factor`."""

    def __init__(self, ordering):
        self.ordering, self.statistics = ordering, {}

    def analyze(self, matrix):
        self.matrix = sp.csc_matrix(matrix)

    def factor(self):
        from scipy.sparse.linalg import splu

        symmetric = dict(diag_pivot_thresh=0.001, options=dict(SymmetricMode=True)) if self.ordering != "COLAMD" else {}
        self.lu = splu(self.matrix, permc_spec=self.ordering, **symmetric)
        self.statistics["factor_entries"] = int(self.lu.nnz) // 2  # of L and U: half, to compare with a symmetric factor

    def solve(self, right):
        return self.lu.solve(np.asfortranarray(right, dtype=float))


class Cholmod:
    """SuiteSparse's supernodal Cholesky, with the BLAS of the system."""

    ORDERINGS = dict(amd=2, metis=3, nesdis=4)

    def __init__(self, ordering):
        self.library = ctypes.CDLL(self.shim())
        self.library.shim_new.restype = ctypes.c_void_p
        self.solver = ctypes.c_void_p(self.library.shim_new(self.ORDERINGS[ordering]))
        self.statistics = {}

    @staticmethod
    def shim():
        """Path of the compiled shim, which is built if it isn't there."""
        source = os.path.join(HERE, "cholmod_shim.c")
        built = os.path.join(tempfile.gettempdir(), f"libcholmod_shim-{os.getuid()}.so")
        if not os.path.exists(built) or os.path.getmtime(built) < os.path.getmtime(source):
            scratch = f"{built}.{os.getpid()}"
            subprocess.check_call(["gcc", "-O2", "-shared", "-fPIC", source, "-o", scratch, "-lcholmod"])
            os.replace(scratch, built)
        return built

    def analyze(self, matrix):
        upper = sp.triu(matrix, format="csr")  # the upper triangle by rows is the lower one by columns
        self.size = matrix.shape[0]
        self.arrays = upper.indptr.astype(np.int64), upper.indices.astype(np.int64), upper.data
        status = self.library.shim_analyze(self.solver, ctypes.c_long(self.size), *map(pointer, self.arrays))
        assert status == 0, f"CHOLMOD's analysis: status {status}"
        numbers = np.zeros(4)
        self.library.shim_stats(self.solver, pointer(numbers))
        self.statistics.update(zip(("factor_entries", "factor_flops", "stored_entries", "supernodes"), numbers.tolist()))

    def factor(self):
        status = self.library.shim_factor(self.solver)
        assert status == 0, f"CHOLMOD's factorization: status {status}"
        del self.arrays

    def solve(self, right):
        right = np.asfortranarray(right, dtype=float)
        solution = np.empty_like(right)
        columns = 1 if right.ndim == 1 else right.shape[1]
        status = self.library.shim_solve(
            self.solver, ctypes.c_long(self.size), ctypes.c_long(columns), pointer(right), pointer(solution)
        )
        assert status == 0
        return solution


class Pardiso:
    """MKL PARDISO through the library that pypardiso loads, without pypardiso's checks and copies.

    kind: 2 symmetric positive definite, -2 symmetric indefinite, 11 general. ordering: 0 minimum degree, 2 nested dissection, 3 the
    same in parallel."""

    def __init__(self, kind=2, ordering=2):
        import pypardiso

        self.call_library = pypardiso.PyPardisoSolver()._mkl_pardiso
        self.kind, self.statistics = kind, {}
        self.handle, self.options = np.zeros(64, np.int64), np.zeros(64, np.int32)
        self.options[0], self.options[1] = 1, ordering
        self.options[17] = self.options[18] = -1  # report entries and flops
        self.options[34] = 1  # count from 0
        self.options[9] = 13 if kind == 11 else 8
        if kind == 11:
            self.options[10] = self.options[12] = 1

    def call(self, phase, right=None):
        def number(value):
            return ctypes.byref(ctypes.c_int32(value))

        def integers(array):
            return array.ctypes.data_as(ctypes.POINTER(ctypes.c_int32))

        size = self.matrix.shape[0]
        right = np.zeros(1) if right is None else np.asfortranarray(right, dtype=float)
        solution = np.empty_like(right)
        columns = 1 if right.ndim == 1 else right.shape[1]
        error = ctypes.c_int32(0)
        self.call_library(
            self.handle.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)), number(1), number(1), number(self.kind), number(phase),
            number(size), pointer(self.matrix.data), integers(self.matrix.indptr), integers(self.matrix.indices),
            integers(np.zeros(size, np.int32)), number(columns), integers(self.options), number(0), pointer(right),
            pointer(solution), ctypes.byref(error),
        )
        assert error.value == 0, f"PARDISO's phase {phase}: error {error.value}"
        return solution

    def analyze(self, matrix):
        self.matrix = sp.csr_matrix(matrix) if self.kind == 11 else sp.triu(matrix, format="csr")
        self.matrix.indptr = self.matrix.indptr.astype(np.int32)
        self.matrix.indices = self.matrix.indices.astype(np.int32)
        self.call(11)
        self.statistics.update(factor_entries=float(self.options[17]), factor_flops=float(self.options[18]) * 1e6)

    def factor(self):
        self.call(22)

    def solve(self, right):
        return self.call(33, right)


class Mumps:
    """MUMPS (sequential library) through python-mumps: symmetric storage, no pivoting, because the matrix is positive definite."""

    def __init__(self, ordering="metis"):
        import mumps

        self.context, self.ordering, self.statistics = mumps.Context(), ordering, {}

    def analyze(self, matrix):
        self.context.set_matrix(sp.triu(matrix, format="coo"), symmetric=True, overwrite_a=True)
        self.context.analyze(ordering=self.ordering)

    def factor(self):
        self.context.factor(reuse_analysis=True, pivot_tol=0.0)
        found = self.context.factor_stats
        self.statistics.update(factor_entries=float(found.nonzeros), factor_flops=float(found.flops))

    def solve(self, right):
        return self.context.solve(np.asfortranarray(right, dtype=float))


def make(tool):
    """A solver by name: superlu, superlu-mmd, cholmod-{amd,metis,nesdis}, pardiso{2,-2,11}[/ORDERING], mumps-{metis,...}."""
    if tool in ("superlu", "superlu-mmd"):
        return SuperLU("COLAMD" if tool == "superlu" else "MMD_AT_PLUS_A")
    if tool.startswith("cholmod-"):
        return Cholmod(tool.removeprefix("cholmod-"))
    if tool.startswith("pardiso"):
        kind, _, ordering = tool.removeprefix("pardiso").partition("/")
        return Pardiso(int(kind), int(ordering or 2))
    if tool.startswith("mumps-"):
        return Mumps(tool.removeprefix("mumps-"))
    raise SystemExit(f"unknown tool {tool}")


def versions(tool):
    """Versions of what a solver uses."""
    from importlib.metadata import version

    found = dict(numpy=np.__version__, scipy=version("scipy"))
    if tool.startswith("pardiso"):
        found.update(mkl=version("mkl"), pypardiso=version("pypardiso"))
    if tool.startswith("mumps"):
        found.update({"python-mumps": version("python-mumps")})
    if tool.startswith("cholmod"):
        numbers = (ctypes.c_int * 3)()
        ctypes.CDLL(Cholmod.shim()).cholmod_version(numbers)
        found.update(cholmod=".".join(map(str, numbers)))
    return found
