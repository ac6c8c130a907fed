"""A flexible body in free flight by SciPy's Radau IIA and by SUNDIALS IDA: the equations that a .dcb.h5 file stands for.

    python3 free_body.py JOB.json RESULT.json

JOB holds `superelement`, `tool` (`scipy-radau` or `ida`), `tolerance`, `end`, `records`, `angular_velocity` and `node`. Written from docs/format.md alone:

    d/dt (J(y) ω + L(y) y') + ω × (J ω + L y') = 0          J(y) = I + Σ y_k I1_k + Σ y_k y_l I2_kl,   L(y)_al = Σ_k y_k L3[a,k,l]
    M y'' + L(y)ᵀ ω' + 2 Σ_k y'_k L3[:,k,:]ᵀ ω - ½ ω (∂J/∂y) ω + K y + C y' = 0

in body axes, over kept modes and orthonormal attachments. The state is (ω, y, y'). RESULT gets seconds, evaluations and the displacement of the node.
"""
import json
import sys
import time

import h5py
import numpy as np


class FreeBody:
    def __init__(self, path):
        with h5py.File(path) as file:
            if "enrichment" in file:
                sys.exit("columns of an enrichment have no basis of their own here")
            eigenvalues, sigma2 = file["modes/eigenvalues"][:], file["residual/sigma2"][:]
            transform = file["residual/transform"][:]
            n, rank = len(eigenvalues), len(sigma2)
            basis = np.zeros((n + transform.shape[0], n + rank))
            basis[:n, :n], basis[n:, n:] = np.eye(n), transform
            self.tensor = file["inertia/tensor"][:]
            self.first = np.einsum("kab,kp->pab", file["inertia/I1"][:], basis)
            self.second = np.einsum("klab,kp,lq->pqab", file["inertia/I2"][:], basis, basis, optimize=True)
            self.coupling = np.einsum("akl,kp,lq->apq", file["inertia/L3"][:], basis, basis, optimize=True)
            self.stiffness = np.concatenate([eigenvalues, sigma2])
            ratio = np.concatenate([file["modes/damping"][:], np.full(rank, file["modes/damping"].attrs["residual"])])
            self.damping = 2 * ratio * np.sqrt(self.stiffness)
            self.shapes = np.hstack([file["modes/shapes"][:].T, file["residual/shapes"][:].T @ transform])
            self.dofs = file["fields/dofs"][:]
        self.n, self.calls = n + rank, 0

    def system(self, x):
        """Mass matrix and right-hand side over (ω', y'')."""
        self.calls += 1
        n, spin, y, rate = self.n, x[:3], x[3 : 3 + self.n], x[3 + self.n :]
        of_y = np.tensordot(y, self.second, (0, 0))  # (l, a, b)
        inertia = self.tensor + np.tensordot(y, self.first, (0, 0)) + np.tensordot(y, of_y, (0, 0))
        slopes = self.first + 2 * of_y
        change = np.tensordot(rate, slopes, (0, 0))
        lever = np.tensordot(y, self.coupling, (0, 1)).reshape(3, n)
        turning = np.tensordot(spin, self.coupling, (0, 0))  # (k, l)
        mass = np.eye(3 + n)
        mass[:3, :3], mass[:3, 3:], mass[3:, :3] = inertia, lever, lever.T
        right = np.empty(3 + n)
        # d/dt (L y') has L(y') y' = 0, as L3 is antisymmetric.
        right[:3] = -change @ spin - np.cross(spin, inertia @ spin + lever @ rate)
        right[3:] = -2 * rate @ turning + 0.5 * (slopes @ spin) @ spin - self.stiffness * y - self.damping * rate
        return mass, right

    def explicit(self, _, x):
        mass, right = self.system(x)
        second = np.linalg.solve(mass, right)
        return np.concatenate([second[:3], x[3 + self.n :], second[3:]])


def main(job_path, result_path):
    with open(job_path) as file:
        job = json.load(file)
    body = FreeBody(job["superelement"])
    n, tolerance = body.n, job["tolerance"]
    start = np.concatenate([job["angular_velocity"], np.zeros(2 * n)])
    times = np.linspace(0, job["end"], job["records"] + 1)
    # Sizes of the motion: spins of the start, deflections of a run of this mechanism.
    spin, deflection = np.linalg.norm(start[:3]), job["deflection"]
    absolute = tolerance * np.concatenate([np.full(3, spin), np.full(n, deflection), np.full(n, deflection * np.sqrt(body.stiffness[0]))])
    clock = time.perf_counter()
    if job["tool"] == "scipy-radau":
        import scipy
        from scipy.integrate import solve_ivp

        found = solve_ivp(body.explicit, (0, job["end"]), start, method="Radau", t_eval=times, rtol=max(tolerance, 1e-13), atol=absolute)
        states, steps, version = found.y.T, None, "SciPy " + scipy.__version__
        solved = found.success
    else:
        import sksundae
        from sksundae.ida import IDA

        def residual(t, x, rate, out):
            mass, right = body.system(x)
            out[: 3] = (mass @ np.concatenate([rate[:3], rate[3 + n :]]) - right)[:3]
            out[3 : 3 + n] = rate[3 : 3 + n] - x[3 + n :]
            out[3 + n :] = (mass @ np.concatenate([rate[:3], rate[3 + n :]]) - right)[3:]

        solver = IDA(residual, rtol=tolerance, atol=absolute, max_num_steps=10_000_000)
        found = solver.solve(times, start, body.explicit(0, start))
        states, steps, version = found.y, None, "SUNDIALS IDA by scikit-sundae " + sksundae.__version__
        solved = found.success
    seconds = time.perf_counter() - clock
    rows = [int(np.nonzero((body.dofs[:, 0] == job["node"]) & (body.dofs[:, 1] == axis))[0][0]) for axis in range(3)]
    moved = states[:, 3 : 3 + n] @ body.shapes[rows].T
    with open(result_path, "w") as file:
        json.dump(dict(solved=bool(solved), seconds=seconds, evaluations=body.calls, steps=steps, version=version, deflection=moved.tolist()), file)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
