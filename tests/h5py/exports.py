"""Reads what `reduce export` writes, with parsers of its own, and compares every number with the superelement's file.

  exports.py SUPERELEMENT.dcb.h5 TARGET FILE [ORACLE]      h5py and numpy; prints one JSON object of largest relative differences

The integrals are computed here from the file's invariants anew, after the formulas of docs/export.md. ORACLE is a file of the same kind and part
that another program wrote: signs of modes, and turns within double roots, are free, so contractions that don't depend on them are compared.
"""
import json, re, struct, sys, zipfile
from io import BytesIO

import h5py
import numpy as np


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def far(a, b, scale=None):
    """Largest difference over the largest entry of b."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    if a.shape != b.shape:
        raise SystemExit(f"shapes differ: {a.shape} and {b.shape}")
    scale = np.abs(b).max() if scale is None else scale
    return float(np.abs(a - b).max() / (scale or 1.0)) if a.size else 0.0


class Basis:
    """Strong coordinates: modes, then attachments combined by T_r."""

    def __init__(self, path):
        f = h5py.File(path)
        Tr = f["residual/transform"][:]
        k, (b, r) = len(f["modes/eigenvalues"]), Tr.shape
        T = np.zeros((k + b, k + r)); T[:k, :k] = np.eye(k); T[k:, k:] = Tr
        self.f, self.T, self.k, self.q = f, T, k, k + r
        self.w2 = np.r_[f["modes/eigenvalues"][:], f["residual/sigma2"][:]]
        zeta = np.r_[f["modes/damping"][:], np.full(r, f["modes/damping"].attrs["residual"])]
        self.damping = 2 * zeta * np.sqrt(self.w2)
        shapes = f["residual/output_shapes"][:] if "residual/output_shapes" in f else f["residual/flexibility"][:]
        self.rows = np.hstack([f["modes/interface_shapes"][:], shapes]) @ T
        self.mass, self.J = float(f["inertia/mass"][()]), f["inertia/tensor"][:]
        self.L1, self.I3 = f["inertia/L1"][:] @ T, f["inertia/I3"][:] @ T
        self.I1 = np.einsum("kab,km->mab", f["inertia/I1"][:], T)
        self.L3 = np.einsum("akl,km,ln->amn", f["inertia/L3"][:], T, T)
        self.I2 = np.einsum("klab,km,ln->mnab", f["inertia/I2"][:], T, T)
        both = lambda of: np.einsum("ikl,km,ln->imn", of, T, T)
        self.K0 = both(f["stiffening/centrifugal"][:]) if "stiffening/centrifugal" in f else None
        self.KG = both(f["stiffening/interface"][:]) if "stiffening/interface" in f else None
        q = self.q
        self.N = np.array([0.5 * self.I1[i] - 0.5 * skew(self.I3[:, i]) for i in range(q)])
        self.P = np.array([[-self.I2[i, j] + 0.5 * skew(self.L3[:, i, j]) for j in range(q)] for i in range(q)])
        self.dofs, self.at = f["interfaces/dofs"][:], f["interfaces/positions"][:]
        self.names = f["interfaces/names"].asstr()[:]

    def motions(self):
        """Displacements of the interfaces: frame, direction, mode."""
        out = np.zeros((len(self.names), 6, self.q))
        for row, (i, d) in enumerate(self.dofs):
            out[i, d] = self.rows[row]
        return out


# --- MBDyn ---------------------------------------------------------------------------------------------------------------------------------

def read_mbdyn(path):
    """Records of a .fem file, as arrays."""
    text = open(path).read()
    blocks = re.split(r"\*\* RECORD GROUP (\d+),[^\n]*\n", text)
    body = {int(n): b for n, b in zip(blocks[1::2], blocks[2::2])}
    data = {n: [line for line in b.splitlines() if line.strip() and not line.startswith("**")] for n, b in body.items()}
    numbers = lambda n: np.array([float(w) for line in data[n] for w in line.split()])
    head = data[1][0].split()
    nodes, q = int(head[1]), sum(int(w) for w in head[2:5]) - int(head[5])
    r = {"labels": data[2][0].split(), "q": q, "nodes": nodes, "records": sorted(data)}
    r["at"] = np.stack([numbers(n) for n in (5, 6, 7)], axis=1)
    r["shapes"] = numbers(8).reshape(q, nodes, 6)
    r["M"], r["K"] = numbers(9).reshape(q, q), numbers(10).reshape(q, q)
    g = numbers(12)
    r["mass"], r["centre"], r["J"] = g[0], g[1:4], g[4:].reshape(3, 3)
    if 13 in data:
        r["D"] = numbers(13).reshape(q, q)
    r["L1"], r["I3"] = numbers(14).reshape(3, q), numbers(15).reshape(3, q)
    r["N"] = numbers(16).reshape(3, q, 3).transpose(1, 0, 2)
    r["L3"] = numbers(17).reshape(3, q, q)
    r["P"] = numbers(18).reshape(3, q, q, 3).transpose(1, 2, 0, 3)
    if 19 in data:
        words = [float(w) for line in data[19] for w in line.split()]
        count, words = int(words[0]), words[1:]
        assert len(words) == count * (1 + q * q)
        r["stiffening"] = {int(words[i * (1 + q * q)]): np.array(words[i * (1 + q * q) + 1 : (i + 1) * (1 + q * q)]).reshape(q, q) for i in range(count)}
    return r


def mbdyn(b, path, oracle):
    r = read_mbdyn(path)
    found = {
        "places": far(r["at"], b.at), "shapes": far(r["shapes"], b.motions().transpose(2, 0, 1)), "M": far(r["M"], np.eye(b.q)), "K": far(r["K"], np.diag(b.w2)),
        "D": far(r["D"], np.diag(b.damping)), "mass": far(r["mass"], b.mass), "J": far(r["J"], b.J), "N": far(r["N"], b.N), "L3": far(r["L3"], b.L3), "P": far(r["P"], b.P),
        "L1": far(r["L1"], b.L1, 1.0), "I3": far(r["I3"], b.I3, 1.0), "records": r["records"],
    }
    if b.K0 is not None:
        for i in range(6):
            found[f"K0 {i + 1}"] = far(r["stiffening"][i + 1], b.K0[i])
    if b.KG is not None:
        place = {name: n for n, name in enumerate(dict.fromkeys(b.dofs[:, 0]))}
        for row, (i, d) in enumerate(b.dofs):
            found[f"KG {row}"] = far(r["stiffening"][13 + 6 * place[i] + d], b.KG[row])
    if oracle:
        found.update(alike(invariant(r, r["shapes"], np.diag(r["K"])), invariant(o := read_mbdyn(oracle), o["shapes"], np.diag(o["K"]))))
    return found


def invariant(r, shapes, w2):
    """Contractions over the modes: the same for any signs, and any turn within a double root."""
    S = shapes.reshape(len(w2), -1).T / w2                                       # what unit forces on the frames deflect
    out = {f"flexibility at {at}": (shapes.reshape(len(w2), -1).T / (w2 - at * w2[0])) @ shapes.reshape(len(w2), -1) for at in (0.0, 0.3)}
    out["w2"], out["J"], out["mass"] = np.sort(w2), r["J"], np.atleast_1d(r["mass"])
    out["SN"] = np.einsum("fk,kab->fab", S, r["N"])
    out["SL3S"] = np.einsum("fk,akl,gl->afg", S, r["L3"], S)
    out["SPS"] = np.einsum("fk,klab,gl->fgab", S, r["P"], S)
    return out


def alike(a, b):
    return {"oracle " + name: far(a[name], b[name]) for name in b}


# --- Exudyn --------------------------------------------------------------------------------------------------------------------------------

def read_exudyn(path):
    f = h5py.File(path)
    plain = {}
    for name, item in f.items():
        kind = item.attrs["datatype"]
        assert isinstance(kind, str)
        if kind != "dict":
            plain[name] = item[()]
            assert kind == {"str": "str"}.get(kind, kind)
    q = int(plain["infoList"][0])
    blocks = lambda name: plain[name].reshape(3, q, 3).transpose(1, 0, 2)
    return dict(
        plain=plain, q=q, shapes=plain["modeBasis"], J=plain["inertiaLocal"], mass=float(plain["totalMass"]), w2=np.diag(plain["stiffnessMatrixReduced"]),
        N=blocks("mXRefTildePsiTilde"), L1=plain["mPhitTPsi"], I3=-plain["mXRefTildePsi"], L1t=blocks("mPhitTPsiTilde"),
        L3=-plain["mPsiTildePsi"].reshape(q, 3, q).transpose(1, 0, 2), P=-plain["mPsiTildePsiTilde"].reshape(q, 3, q, 3).transpose(0, 2, 1, 3),
    )


def exudyn(b, path, oracle):
    r = read_exudyn(path)
    p, f, q = r["plain"], b.f, b.q
    found = {
        "K": far(p["stiffnessMatrixReduced"], np.diag(b.w2)), "M": far(p["massMatrixReduced"], np.eye(q)), "J": far(r["J"], b.J), "mass": far(r["mass"], b.mass),
        "Mtt": far(p["Mtt"], b.mass * np.eye(3)), "N": far(r["N"], b.N), "L3": far(r["L3"], b.L3), "P": far(r["P"], b.P), "L1": far(r["L1"], b.L1, 1.0), "I3": far(r["I3"], b.I3, 1.0),
        "L1 skew": far(r["L1t"], [skew(v) for v in b.L1.T], 1.0), "info": [int(v) for v in p["infoList"]], "triangles": list(p["trigList"].shape),
        "texts": [p["rigidBodyNodeType"].decode(), p["type"].decode()], "version": int(p["fileVersion"]),
    }
    if "fields/dofs" in f:
        pts, d = f["mesh/points"][:] - f["frame/origin"][:], f["fields/dofs"][:]
        d, columns = d[d[:, 1] < 3], np.flatnonzero(d[:, 1] < 3)
        Psi = np.zeros((3 * len(pts), q))
        Psi[d[:, 0] * 3 + d[:, 1]] = (np.vstack([f["modes/shapes"][:], f["residual/shapes"][:]]).T @ b.T)[columns]
        found["modeBasis"], found["xRef"] = far(p["modeBasis"], Psi), far(p["xRef"], pts.ravel())
    else:
        motions, at, shapes = b.motions(), p["xRef"].reshape(-1, 3), p["modeBasis"].reshape(-1, 3, q)
        worst = 0.0
        for i in range(len(b.names)):
            for n in range(4 * i, 4 * i + 4):
                arm = at[n] - b.at[i]
                worst = max(worst, far(shapes[n], motions[i, :3] + np.cross(motions[i, 3:].T, arm).T, np.abs(shapes).max()))
        found["four nodes a frame"] = worst
    if oracle:
        o = read_exudyn(oracle)
        found.update(alike(invariant(r, r["shapes"].T, r["w2"]), invariant(o, o["shapes"].T, o["w2"])))
        found["oracle triangles"] = list(o["plain"]["trigList"].shape)
        area = lambda x: float(np.linalg.norm(np.cross(*(lambda a: (a[:, 1] - a[:, 0], a[:, 2] - a[:, 0]))(x["xRef"].reshape(-1, 3)[x["trigList"]])), axis=1).sum() / 2)
        found["oracle area"] = area(p) / area(o["plain"]) - 1
    a = p["xRef"].reshape(-1, 3)[p["trigList"]]
    found["volume"] = float(np.einsum("ta,ta->", a[:, 0], np.cross(a[:, 1], a[:, 2])) / 6)    # positive: seen from outside
    return found


def read_mtx(path):
    """Symmetric coordinate Matrix Market, dense."""
    lines = [line for line in open(path) if not line.startswith("%")]
    n = int(lines[0].split()[0])
    entries = np.array([line.split() for line in lines[1:]], float)
    out, i, j = np.zeros((n, n)), entries[:, 0].astype(int) - 1, entries[:, 1].astype(int) - 1
    out[i, j] = out[j, i] = entries[:, 2]
    return out


def integrals(path, mass):
    """Exudyn's arrays by integration over the finite elements' mass, for the nodes and shapes in the file: as Exudyn itself computes them."""
    p, M = read_exudyn(path)["plain"], read_mtx(mass)
    Psi, x = p["modeBasis"], p["xRef"]
    n, q = len(x) // 3, Psi.shape[1]
    T, X = np.tile(np.eye(3), (n, 1)), np.vstack([skew(v) for v in x.reshape(-1, 3)])
    Pt = np.hstack([np.vstack([skew(v) for v in Psi[:, k].reshape(-1, 3)]) for k in range(q)])
    m, size, arm = float(p["totalMass"]), np.abs(Psi).max(), np.abs(x).max()
    c = T.T @ M @ x / m
    found = {
        "Mtt": far(p["Mtt"], T.T @ M @ T), "inertiaLocal": far(p["inertiaLocal"], X.T @ M @ X), "chiU": far(p["chiU"], c, arm), "chiUtilde": far(p["chiUtilde"], skew(c), arm),
        "massMatrixReduced": far(p["massMatrixReduced"], Psi.T @ M @ Psi), "mPsiTildePsi": far(p["mPsiTildePsi"], Pt.T @ M @ Psi),
        "mPsiTildePsiTilde": far(p["mPsiTildePsiTilde"], Pt.T @ M @ Pt), "mPhitTPsi": far(p["mPhitTPsi"], T.T @ M @ Psi, m * size),
        "mPhitTPsiTilde": far(p["mPhitTPsiTilde"], T.T @ M @ Pt, m * size), "mXRefTildePsi": far(p["mXRefTildePsi"], X.T @ M @ Psi, m * size * arm),
        "mXRefTildePsiTilde": far(p["mXRefTildePsiTilde"], X.T @ M @ Pt),
    }
    modes = found.pop("massMatrixReduced")                                       # as orthonormal as the reduction found them
    return {"integrals": max(found.values()), "orthonormality": modes, **found}


# --- primal forms --------------------------------------------------------------------------------------------------------------------------

def read_mat(path):
    """Real matrices, texts and lists of texts of a MATLAB 5 file without compression."""
    data = open(path, "rb").read()
    assert data[124:128] == b"\x00\x01IM", data[124:128]

    def elements(at, end):
        while at < end:
            kind, size = struct.unpack_from("<II", data, at)
            if kind >> 16:
                kind, size, body, at = kind & 0xFFFF, kind >> 16, at + 4, at + 8
            else:
                body, at = at + 8, at + 8 + size + (-size) % 8
            yield kind, body, size

    def array(at, end):
        (_, flags, _), (_, dims, ndims), (_, name, length), *rest = elements(at, end)
        cls, shape = data[flags], struct.unpack_from(f"<{ndims // 4}i", data, dims)
        name = data[name : name + length].decode()
        if cls == 6:
            kind, body, size = rest[0]
            dtype = {1: "<i1", 2: "<u1", 3: "<i2", 4: "<u2", 5: "<i4", 6: "<u4", 9: "<f8"}[kind]
            return name, np.frombuffer(data, dtype, size // np.dtype(dtype).itemsize, body).reshape(shape, order="F").astype(float)
        if cls == 4:
            kind, body, size = rest[0]
            return name, data[body : body + size].decode("utf-16-le" if kind == 4 else "latin-1")
        assert cls == 1, cls
        return name, [array(body, body + size)[1] for _, body, size in rest]

    return dict(array(body, body + size) for kind, body, size in elements(128, len(data)) if kind == 14)


def read_npz(path):
    archive = zipfile.ZipFile(path)
    return {name[:-4]: np.lib.format.read_array(BytesIO(archive.read(name)), allow_pickle=False) for name in archive.namelist()}


def primal(b):
    """The same with other algebra: g itself as coordinate, F inverted plainly."""
    f = b.f
    C, F = f["modes/interface_shapes"][:], f["residual/flexibility"][:]
    n, k = C.shape
    Rb = np.zeros((n, 6))
    for r, (i, d) in enumerate(b.dofs):
        Rb[r] = np.vstack([np.hstack([np.eye(3), -skew(b.at[i])]), np.hstack([np.zeros((3, 3)), np.eye(3)])])[d]
    block = lambda *blocks: np.block([[x if i == j else np.zeros((x.shape[0], y.shape[1])) for j, y in enumerate(blocks)] for i, x in enumerate(blocks)])
    Mq, Kq = block(b.mass * np.eye(3), b.J, np.eye(k), f["residual/mass"][:]), block(np.zeros((6, 6)), np.diag(b.w2[:k]), F)
    Pi, Fi = np.linalg.pinv(Rb), np.linalg.inv(F)
    T = np.block([[Pi, np.eye(6), np.zeros((6, k))], [np.zeros((k, n + 6)), np.eye(k)], [Fi @ (np.eye(n) - Rb @ Pi), -Fi @ Rb, -Fi @ C]])
    return T.T @ Kq @ T, T.T @ Mq @ T, Rb


def identities(b, K, M):
    """What a primal form must keep: rigid motions, mass, free frequencies."""
    Rb = primal(b)[2]
    R = np.vstack([Rb, np.zeros((len(K) - len(Rb), 6))])
    rigid = np.zeros((6, 6)); rigid[:3, :3] = b.mass * np.eye(3); rigid[3:, 3:] = b.J
    L = np.linalg.inv(np.linalg.cholesky((M + M.T) / 2))
    w2 = np.linalg.eigvalsh(L @ ((K + K.T) / 2) @ L.T)
    return {"K R": float(np.abs(K @ R).max() / np.abs(K).max()), "rigid inertia": far(R.T @ M @ R, rigid), "free": float(np.abs(w2[6:] / np.sort(b.w2) - 1).max()), "symmetric": far(K, K.T)}


def clamped(K, M, held):
    """First seven squares with some coordinates held."""
    keep = np.setdiff1d(np.arange(len(K)), held)
    K, M = K[np.ix_(keep, keep)], M[np.ix_(keep, keep)]
    L = np.linalg.inv(np.linalg.cholesky(M))
    return np.linalg.eigvalsh(L @ K @ L.T)[:7].tolist()


def clamped_finite_elements(superelement, stiffness, mass):
    """First seven squares of the finite elements whose first frame, the least-squares mean of a node set, is at rest."""
    K, M, f = read_mtx(stiffness), read_mtx(mass), h5py.File(superelement)
    place, points = f["interfaces/positions"][0] + f["frame/origin"][:], f["mesh/points"][:]
    nodes = min((group[:] for group in f["mesh/point_sets"].values()), key=lambda of: np.linalg.norm(points[of].mean(axis=0) - place))
    G = np.zeros((len(K), 6))                                                    # the frame is (GᵀG)⁻¹ Gᵀ u
    for node in nodes:
        G[3 * node : 3 * node + 3] = np.hstack([np.eye(3), -skew(points[node] - place)])
    Z = np.linalg.svd(G.T)[2][6:].T
    return clamped(Z.T @ K @ Z, Z.T @ M @ Z, [])


def compare_primal(b, K, M):
    Kp, Mp, _ = primal(b)
    return {"K": far(K, Kp), "M": far(M, Mp), **identities(b, K, M), "clamped": clamped(K, M, np.arange(6))}


def simscape(b, path, oracle):
    m = read_mat(path)
    found = {**compare_primal(b, m["K"], m["M"]), "origins": far(m["origins"], b.at), "names": m["names"], "source": m["source"]}
    turn = b.f["interfaces/orientations"][:]
    for i, (w, x, y, z) in enumerate(m["quaternions"]):
        R = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        found[f"axes {i}"] = far(R, turn[i])
    if oracle:
        o, n = read_mat(oracle), len(b.dofs) + 6                                  # modes are turned in double roots: frames and inertia relief alone
        found["oracle K"], found["oracle M"] = far(m["K"][:n, :n], o["K"][:n, :n]), far(m["M"][:n, :n], o["M"][:n, :n])
        found["oracle clamped"] = far(clamped(m["K"], m["M"], np.arange(6)), clamped((o["K"] + o["K"].T) / 2, (o["M"] + o["M"].T) / 2, np.arange(6)))
    return found


def npz(b, path, _):
    z = read_npz(path)
    found = {**compare_primal(b, z["K"], z["M"]), "positions": far(z["positions"], b.at), "names": z["names"].tolist(), "n_modes": int(z["n_modes"]), "arrays": sorted(z)}
    found["boundary"] = bool((z["boundary"] == b.dofs).all())
    found["rigid"] = far(z["rigid"], primal(b)[2])
    found["orientations"] = far(z["orientations"], b.f["interfaces/orientations"][:])
    if "C" in z:
        L = np.linalg.inv(np.linalg.cholesky(z["M"]))
        rates = np.linalg.eigvalsh(L @ z["C"] @ L.T)
        found["C"] = far(rates[6:], np.sort(b.damping))
    return found


# --- Nastran -------------------------------------------------------------------------------------------------------------------------------

def read_op4(path):
    data, at, out = open(path, "rb").read(), 0, {}

    def record():
        nonlocal at
        size = struct.unpack_from("<i", data, at)[0]
        body = data[at + 4 : at + 4 + size]
        assert struct.unpack_from("<i", data, at + 4 + size)[0] == size
        at += size + 8
        return body

    while at < len(data):
        head = record()
        columns, rows, form, kind = struct.unpack_from("<4i", head)
        assert (form, kind, len(head)) == (6, 2, 24)
        matrix = np.zeros((rows, columns))
        while True:
            body = record()
            column, first, words = struct.unpack_from("<3i", body)
            if column > columns:
                break
            matrix[first - 1 : first - 1 + words // 2, column - 1] = np.frombuffer(body, "<f8", words // 2, 12)
        out[head[16:24].decode().strip()] = matrix
    return out


def read_dmig(path):
    """DMIG of symmetric form, places in the order of points, and places of GRIDs."""
    entries, grids, column, name = {}, {}, None, None
    lines = open(path).read().splitlines()
    for n, line in enumerate(lines):
        fields = [line[8 + 16 * i : 24 + 16 * i].strip() for i in range(4)]
        if line.startswith("DMIG*"):
            name, column = fields[0], (int(fields[1]), int(fields[2]))
            entries.setdefault(name, {})
        elif line.startswith("GRID*"):
            grids[int(fields[0])] = [float(v.replace("D", "e")) for v in (fields[2], fields[3], lines[n + 1][8:24].strip())]
        elif line.startswith("*") and name:
            assert all(len(f) <= 16 for f in fields) and len(line) <= 72
            entries[name][(int(fields[0]), int(fields[1])), column] = float(fields[2].replace("D", "e"))
    order = sorted({p for of in entries.values() for pair in of for p in pair})
    place = {p: i for i, p in enumerate(order)}
    out = {}
    for name, of in entries.items():
        matrix = out[name] = np.zeros((len(order), len(order)))
        for (row, column), value in of.items():
            matrix[place[row], place[column]] = matrix[place[column], place[row]] = value
    return out, np.array([grids[g] for g in sorted(grids)])


def nastran(b, path, _):
    if path.endswith(".op4"):
        m = read_op4(path)
        return compare_primal(b, m["KXX"], m["MXX"])
    m, grids = read_dmig(path)
    return {**compare_primal(b, m["KAAX"], m["MAAX"]), "places": far(grids, b.at)}


# --- SID_FEM -------------------------------------------------------------------------------------------------------------------------------

def read_sid(path):
    """Nested names; matrices as m0, m1 (row, mode, column)."""
    root, stack, matrix, nodes = {}, [], None, []
    here = root
    for line in open(path, encoding="latin-1").read().splitlines()[1:]:
        line = line.strip()
        if not line:
            continue
        if line.startswith("end "):
            here = stack.pop()
            continue
        if "=" not in line:
            stack.append(here)
            here = here.setdefault(line.split()[0], {})
            continue
        key, value = (part.strip() for part in line.split("=", 1))
        if key == "new modal":
            continue_at = here
            stack.append(here)
            here = here.setdefault("modal", {})
        elif key == "new node":
            stack.append(here)
            here = {"id": value}
            nodes.append(here)
        elif found := re.fullmatch(r"(m[01])\(([^)]*)\)", key):
            place = tuple(int(w) - 1 for w in found[2].split(","))
            here.setdefault(found[1], {})[place] = float(value.replace("D", "e"))
        else:
            here[key] = value
    modal = root["part"]["modal"]

    def matrices(of):
        for name, item in of.items():
            if isinstance(item, dict) and "nrow" in item:
                r, c, q, s = (int(item[k]) for k in ("nrow", "ncol", "nq", "structure"))
                m0, m1 = np.zeros((r, c)), np.zeros((r, q, c))
                for place, value in item.get("m0", {}).items():
                    m0[place] = value
                for place, value in item.get("m1", {}).items():
                    m1[place] = value
                if s == 4:
                    m0 = np.eye(r)
                of[name] = m0, m1
    matrices(modal)
    for node in nodes:
        matrices(node)
    modal["nodes"] = nodes
    return modal


VECTOR = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
SPINS = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]


def tensor(of):
    """J of either dialect: J, and its slopes mode after mode."""
    m0, m1 = of
    if m0.shape == (3, 3):
        return m0, m1.transpose(1, 0, 2)
    J, slopes = np.zeros((3, 3)), np.zeros((m1.shape[1], 3, 3))
    for i, (a, c) in enumerate(VECTOR):
        J[a, c] = J[c, a] = m0[i, 0]
        slopes[:, a, c] = slopes[:, c, a] = m1[i, :, 0]
    return J, slopes


def sid_identities(m):
    """What holds in any such file: J, Gr, Oe and Ge come from the same integrals. The antisymmetric part of Gr is that of Cr's constant part."""
    J, I1 = tensor(m["J"])
    q = len(I1)
    Gr, Ge, Oe, Cr, Ct = m["Gr"][0], m["Ge"][0], m["Oe"][0], m["Cr"], m["Ct"][0]
    N = np.array([Gr[:, 3 * k : 3 * k + 3] / 2 for k in range(q)])
    L3 = np.einsum("ika->aki", Cr[1])
    spins = np.array([[-(0.5 if a == c else 1.0) * I1[k][a, c] for a, c in SPINS] for k in range(q)])
    return {
        "Gr symmetric part = I1": far([n + n.T for n in N], I1), "Oe m0 = I1": far(Oe, spins, np.abs(I1).max()),
        "Ge = 2 L3": far(Ge, np.hstack([2 * L3[a].T for a in range(3)]), max(np.abs(Ge).max(), 1e-3 * np.abs(I1).max())), "Ct = m1 of mdCM": far(Ct, m["mdCM"][1][:, :, 0].T, 1.0),
        "L3 antisymmetric": far(L3, -L3.transpose(0, 2, 1), max(np.abs(L3).max(), 1e-3 * np.abs(I1).max())), "modes": q,
    }


def sid(b, path, _):
    m = read_sid(path)
    J, I1 = tensor(m["J"])
    q, scale = b.q, lambda a: np.abs(a).max()
    found = {
        **sid_identities(m), "J": far(J, b.J), "I1": far(I1, b.I1), "Gr": far(m["Gr"][0], np.hstack([2 * n for n in b.N])), "Me": far(m["Me"][0], np.eye(q)),
        "Ke": far(m["Ke"][0], np.diag(b.w2)), "De": far(m["De"][0], np.diag(b.damping)), "Ct": far(m["Ct"][0], b.L1.T, 1.0), "Cr": far(m["Cr"][0], b.I3.T, 1.0),
        "Cr m1": far(m["Cr"][1], np.einsum("aki->ika", b.L3)), "Ge": far(m["Ge"][0], np.hstack([2 * b.L3[a].T for a in range(3)])),
        "mass": far(float(m["refmod"]["mass"].replace("D", "e")), b.mass), "mdCM": far(m["mdCM"][0], np.zeros((3, 1)), 1.0),
    }
    slopes = np.stack([-(1.0 if a == c else 2.0) * b.I2[:, :, a, c] + (0 if b.K0 is None else b.K0[i]) for i, (a, c) in enumerate(SPINS)], axis=2)
    found["Oe m1"] = far(m["Oe"][1], slopes)
    motions = b.motions()
    for i, node in enumerate(m["nodes"]):
        found[f"node {i}"] = max(
            far(node["origin"][0][:, 0], b.at[i]), far(node["origin"][1][:, :, 0], motions[i, :3]), far(node["phi"][0], motions[i, :3]), far(node["psi"][0], motions[i, 3:]),
            far(node["AP"][0], np.eye(3)), far(node["AP"][1].transpose(1, 0, 2), [skew(motions[i, 3:, k]) for k in range(q)]))
    return found


# --- glTF ----------------------------------------------------------------------------------------------------------------------------------

def gltf(b, path, _):
    data = open(path, "rb").read()
    magic, version, length, size, kind = struct.unpack_from("<4sIII4s", data)
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    scene, binary = json.loads(data[20 : 20 + size]), data[28 + size :]
    assert scene["buffers"] == [{"byteLength": len(binary)}] and data[24 + size : 28 + size] == b"BIN\0"

    def read(index):
        a = scene["accessors"][index]
        view = scene["bufferViews"][a["bufferView"]]
        dtype, width = {5126: "<f4", 5125: "<u4"}[a["componentType"]], {"SCALAR": 1, "VEC3": 3}[a["type"]]
        assert view["byteOffset"] % 4 == 0 and view["byteLength"] == 4 * width * a["count"]
        values = np.frombuffer(binary, dtype, width * a["count"], view["byteOffset"]).reshape(-1, width)
        if "min" in a:
            assert (values.min(axis=0) == np.float32(a["min"])).all() and (values.max(axis=0) == np.float32(a["max"])).all()
        return values

    mesh, = scene["meshes"]
    primitive, = mesh["primitives"]
    at, cells = read(primitive["attributes"]["POSITION"]), read(primitive["indices"])
    assert cells.max() == len(at) - 1
    f = b.f
    origin = f["frame/origin"][:] if "body" else 0
    points = np.zeros((len(f["mesh/points"]), 3)); points[:, : len(origin)] = f["mesh/points"][:] - origin
    order = np.lexsort(points.T)
    used = [int(np.argmin(((points - p) ** 2).sum(axis=1))) for p in at]
    shapes = f["modes/shapes"][:]
    dofs, worst = f["fields/dofs"][:], 0.0
    for k, target in enumerate(primitive.get("targets", [])):
        u = np.zeros((len(points), 3))
        for column, (node, d) in enumerate(dofs):
            if d < 3:
                u[node, d] = shapes[k, column]
        found, wanted = read(target["POSITION"]), u[used]
        worst = max(worst, far(found / np.abs(found).max(), wanted * (np.sign((found * wanted).sum()) / np.abs(wanted).max())))
    frames = [read(a["samplers"][0]["output"]).reshape(5, -1) for a in scene["animations"]]
    for k, frame in enumerate(frames):
        assert (frame[:, k] == [0, 1, 0, -1, 0]).all() and np.abs(frame).sum() == 2
    return {"positions": far(at, points[used]), "targets": worst, "animations": len(frames), "names": mesh["extras"]["targetNames"][:1], "mode": primitive.get("mode", 4), "cells": len(cells)}


def vtu(b, path, _):
    import meshio

    grid, f = meshio.read(path), b.f
    origin = f["frame/origin"][:]
    points = np.zeros((len(f["mesh/points"]), 3))
    points[:, : f["mesh/points"].shape[1]] = f["mesh/points"][:] - origin[: f["mesh/points"].shape[1]]
    columns = [f["modes/shapes"][k] for k in range(len(f["modes/shapes"]))] + [f["residual/shapes"][k] for k in range(len(f["residual/shapes"]))]
    assert len(columns) == len(grid.point_data), (len(columns), len(grid.point_data))
    dofs, worst = f["fields/dofs"][:], 0.0
    for column, found in zip(columns, grid.point_data.values()):
        u = np.zeros((len(points), 3))
        moves = dofs[:, 1] < 3
        u[dofs[moves, 0], dofs[moves, 1]] = column[moves]
        worst = max(worst, far(found, u))
    return {"positions": far(grid.points, points), "fields": worst, "names": list(grid.point_data)[:1], "cells": sum(len(block.data) for block in grid.cells)}


if __name__ == "__main__":
    if sys.argv[1] == "sid-identities":
        print(json.dumps(sid_identities(read_sid(sys.argv[2]))))
    elif sys.argv[1] == "exudyn-integrals":
        print(json.dumps(integrals(*sys.argv[2:])))
    elif sys.argv[1] == "clamped-finite-elements":
        print(json.dumps(clamped_finite_elements(*sys.argv[2:])))
    elif sys.argv[1] == "primal-squares":
        z = read_npz(sys.argv[2])
        R, L = np.zeros((len(z["K"]), 6)), np.linalg.inv(np.linalg.cholesky(z["M"]))
        R[: len(z["rigid"])] = z["rigid"]
        print(json.dumps({"K R": float(np.abs(z["K"] @ R).max() / np.abs(z["K"]).max()), "squares": np.linalg.eigvalsh(L @ z["K"] @ L.T).tolist(), "clamped": clamped(z["K"], z["M"], np.arange(6))}))
    else:
        source, target, path = sys.argv[1:4]
        reader = {"npz": npz, "simscape": simscape, "nastran": nastran, "exudyn": exudyn, "mbdyn": mbdyn, "sid": sid, "gltf": gltf, "vtu": vtu}[target]
        basis = Basis(source) if target not in ("gltf", "vtu") else type("File", (), {"f": h5py.File(source)})
        print(json.dumps(reader(basis, path, sys.argv[4] if len(sys.argv) > 4 else None)))
