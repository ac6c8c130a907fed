"""Small matrices in every binary form that other tools write: which types, orders and compressions a reader meets.

  python binary_variants.py numpy|matlab|petsc      needs NumPy and SciPy, h5py (matlab), petsc4py (petsc)
All files of a kind hold the K of variants.mtx (12 rows, full storage) and the M of variants.mass.mtx (diagonal and one pair).
"""
import os, struct, sys, zlib
import numpy as np, scipy.sparse as sp

HERE = os.path.dirname(os.path.abspath(__file__))


def out(*parts):
    path = os.path.join(HERE, "..", *parts)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    return path


def matrices():
    n = 12
    k, m = np.zeros((n, n)), np.diag(np.arange(1, n + 1) / 7)
    for i in range(n):
        k[i, i] = 4 + np.sqrt(i + 2)
        for j in (i + 1, i + 4):
            if j < n:
                k[i, j] = k[j, i] = -np.pi / (i + j + 1)
    m[3, 8] = m[8, 3] = 0.1
    return sp.csr_matrix(k), sp.csr_matrix(m)


def text():
    for name, a in zip(("variants.mtx", "variants.mass.mtx"), matrices()):
        a = sp.tril(a).tocoo()
        with open(out(name), "w") as f:
            f.write("%%MatrixMarket matrix coordinate real symmetric\n%d %d %d\n" % (*a.shape, a.nnz))
            f.writelines("%d %d %.17g\n" % (i + 1, j + 1, v) for i, j, v in zip(a.row, a.col, a.data))


def petsc():
    import petsc4py
    petsc4py.init([])
    from petsc4py import PETSc
    k, m = matrices()
    n = k.shape[0]

    def viewer(name):
        return PETSc.Viewer().createBinary(out("petsc", name), "w")

    def aij(a):
        a = PETSc.Mat().createAIJ(size=a.shape, csr=(a.indptr, a.indices, a.data))
        a.assemble()
        return a

    v = viewer("variants_two_and_a_vector.petsc")
    aij(k).view(v)
    x = PETSc.Vec().createSeq(5)
    x.set(1.5)
    x.view(v)
    PETSc.IS().createGeneral([3, 1, 2]).view(v)
    aij(m).view(v)
    v.destroy()
    d = PETSc.Mat().createDense(k.shape, array=k.toarray())
    d.assemble()
    v = viewer("variants_dense.petsc")
    d.view(v)
    v.destroy()
    v = viewer("variants_dense_native.petsc")
    v.pushFormat(PETSc.Viewer.Format.NATIVE)
    d.view(v)
    v.destroy()
    for name in ("two_and_a_vector", "dense", "dense_native"):
        name = out("petsc", f"variants_{name}.petsc.info")
        if os.path.exists(name):
            os.remove(name)
    # What builds with 64-bit indices, single precision and complex numbers write, after PETSc's documentation.
    def write(name, integer, value, a):
        with open(out("petsc", name), "wb") as f:
            np.array([1211216, n, n, a.nnz], integer).tofile(f)
            np.diff(a.indptr).astype(integer).tofile(f)
            a.indices.astype(integer).tofile(f)
            a.data.astype(value).tofile(f)

    write("variants_64bit.petsc", ">i8", ">f8", k)
    write("variants_single.petsc", ">i4", ">f4", k)
    write("variants_complex.petsc", ">i4", ">c16", k)
    shuffled = k.copy()
    for i in range(n):
        ends = slice(shuffled.indptr[i], shuffled.indptr[i + 1])
        shuffled.indices[ends] = shuffled.indices[ends][::-1].copy()
        shuffled.data[ends] = shuffled.data[ends][::-1].copy()
    write("variants_unsorted.petsc", ">i4", ">f8", shuffled)
    write("variants_upper.petsc", ">i4", ">f8", sp.triu(k).tocsr())


def numpy():
    import io, zipfile
    k, m = matrices()
    n = k.shape[0]
    dof_ref = np.array([[10 * i + 3, d] for i in range(n // 3) for d in range(3)])
    whole = np.round(k.toarray())
    file = lambda name: out("scipy", name)

    shuffled = k.copy()
    shuffled.indices, shuffled.indptr = k.indices.astype("i8"), k.indptr.astype("i8")
    for i in range(n):
        ends = slice(k.indptr[i], k.indptr[i + 1])
        shuffled.indices[ends], shuffled.data[ends] = k.indices[ends][::-1], k.data[ends][::-1]
    shuffled.has_sorted_indices = False
    sp.save_npz(file("variants_csr_unsorted.npz"), shuffled)
    twice = k.tocoo()
    half = twice.data / 2                       # exact, and so is the sum; one place more with a zero
    twice = sp.coo_matrix((np.r_[half, half, 0.0], (np.r_[twice.row, twice.row, 0], np.r_[twice.col, twice.col, 11])), k.shape)
    sp.save_npz(file("variants_coo_twice.npz"), twice, compressed=False)
    sp.save_npz(file("variants_bsr.npz"), sp.bsr_array(k, blocksize=(4, 4)))
    sp.save_npz(file("variants_dia.npz"), sp.dia_array(k))
    sp.save_npz(file("variants_upper.npz"), sp.triu(k).tocsc())
    c = k.tocsc()
    np.savez(file("variants_by_hand.npz"), K_data=c.data.astype(">f8"), K_indices=c.indices.astype(">i8"), K_indptr=c.indptr, K_shape=c.shape,
             K_format="csc", M=np.asfortranarray(m.toarray()), dof_ref=dof_ref.astype("i4"), names=np.array(["foot", "tip"]), nodes=np.zeros((4, 3)))
    np.savez_compressed(file("variants_without_shape.npz"), **{"K.data": k.data, "K.indices": k.indices, "K.indptr": k.indptr})
    types = {f"d{o}{t}".replace("<", "l").replace(">", "b"): (np.abs(whole) if t[0] == "u" else whole).astype(o + t)
             for o in "<>" for t in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8")}
    np.savez_compressed(file("variants_types.npz"), **types, flags=np.eye(3, dtype=bool), z=np.eye(2) * 1j, half=np.eye(2, dtype="f2"), line=np.arange(3))
    np.save(file("variants.npy"), k.toarray())
    np.save(file("variants_dof_ref.npy"), np.asfortranarray(dof_ref, dtype="u2"))

    class Pipe(io.RawIOBase):                   # an archive on its way through a pipe has data descriptors
        def __init__(self, file):
            self.file = file
        def writable(self):
            return True
        def write(self, data):
            return self.file.write(data)

    with open(file("variants_streamed.npz"), "wb") as f:
        np.savez_compressed(io.BufferedWriter(Pipe(f)), K=k.toarray())

    # To be refused.
    np.savez(file("pickled_ansys.npz"), K=sp.triu(k).tocsc(), M=m, dof_ref=dof_ref)
    np.savez(file("refused_names.npz"), K=k.toarray(), names=np.array(["foot", "tip"], dtype=object))
    outside, nan = k.copy(), k.copy()
    outside.indices[0], nan.data[-1] = n, np.nan
    pieces = dict(indices=outside.indices, indptr=k.indptr, data=k.data, shape=k.shape, format=b"csr")
    np.savez(file("refused_index.npz"), **pieces)
    sp.save_npz(file("refused_nan.npz"), nan)
    np.savez(file("refused_places.npz"), row=[0, -1], col=[0, 0], data=[1.0, 2.0], shape=k.shape, format=b"coo")
    large = k.astype("i8")
    large.data[:] = 2**53 + 1
    sp.save_npz(file("refused_large.npz"), large)

    def member(a):
        b = io.BytesIO()
        np.save(b, a)
        return b.getvalue()

    with zipfile.ZipFile(file("refused_bzip2.npz"), "w", zipfile.ZIP_BZIP2) as z:
        z.writestr("K.npy", member(k.toarray()))
    import warnings
    with zipfile.ZipFile(file("refused_twice.npz"), "w") as z, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        z.writestr("K.npy", member(np.eye(2)))
        z.writestr("K.npy", member(np.eye(3)))
    plain = io.BytesIO()
    with zipfile.ZipFile(plain, "w") as z:
        z.writestr("K.npy", member(np.eye(2)))
    plain = bytearray(plain.getvalue())
    plain[6] |= 1
    plain[plain.index(b"PK\1\2") + 8] |= 1
    open(file("refused_encrypted.npz"), "wb").write(plain)


def matlab():
    import h5py
    import scipy.io as sio
    k, m = matrices()
    n = k.shape[0]
    dof_ref = np.array([[10 * i + 3, d] for i in range(n // 3) for d in range(3)])
    for name, compressed in (("variants_structure.mat", False), ("variants_structure_compressed.mat", True)):
        cell = np.empty((1, 2), dtype=object)
        cell[0, 0], cell[0, 1] = k, "in a cell"
        sio.savemat(out("matlab", name), {
            "title": "a part", "cell": cell, "s": {"K": k.tocsc(), "inner": {"M": m.toarray(), "text": "x"}, "empty": np.zeros((0, 0))},
            "list": np.array([({"a": 1},), ({"a": 2},)], dtype=[("x", "O")]), "z": 1j * np.eye(3), "flags": np.eye(2, dtype=bool),
            "nodes": np.arange(12.0).reshape(4, 3), "cube": np.zeros((2, 2, 2)), "K1": k.toarray(), "dofs": dof_ref.astype(float),
        }, do_compression=compressed)
    sio.savemat(out("matlab", "variants_labelled.mat"), {"dof_ref": dof_ref, "K": k.tocsc(), "M": m.toarray()})

    # What savemat doesn't write, after MathWorks' description: both byte orders, values in smaller types, room behind the last entry.
    def element(e, kind, data):
        if 0 < len(data) <= 4:
            return struct.pack(e + "I", len(data) << 16 | kind) + data.ljust(4, b"\0")
        return struct.pack(e + "II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    kinds = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 9, "i8": 12, "u8": 13}

    def array(e, name, cls, shape, parts, nzmax=0):
        body = element(e, 6, struct.pack(e + "II", cls, nzmax)) + element(e, 5, struct.pack(e + "ii", *shape)) + element(e, 1, name.encode())
        for values, kind in parts:
            body += element(e, kinds[kind], np.asarray(values).astype(e + kind).tobytes())
        return element(e, 14, body)

    def header(e):
        return b"MATLAB 5.0 MAT-file, Platform: by hand".ljust(124) + struct.pack(e + "H", 0x0100) + (b"IM" if e == "<" else b"MI")

    whole = sp.csc_matrix(np.round(k.toarray()))
    for order, e in (("little", "<"), ("big", ">")):
        room = 5
        k_parts = [(np.r_[k.tocsc().indices, np.full(room, 99)], "i4"), (k.tocsc().indptr, "i4"), (np.r_[k.tocsc().data, np.full(room, np.nan)], "f8")]
        content = array(e, "K", 5, k.shape, k_parts, k.nnz + room)
        content += array(e, "small", 5, k.shape, [(whole.indices, "u1"), (whole.indptr, "u2"), (whole.data, "i1")])
        for kind in kinds:
            values = np.abs(whole.toarray()) if kind[0] == "u" else whole.toarray()
            content += array(e, "d_" + kind, 6, k.shape, [(values.ravel("F"), kind)])
        content += array(e, "one", 6, (1, 1), [([3], "u1")])
        squeezed = zlib.compress(array(e, "M", 6, m.shape, [(m.toarray().ravel("F"), "f8")]))
        content += struct.pack(e + "II", 15, len(squeezed)) + squeezed
        with open(out("matlab", f"variants_by_hand_{order}.mat"), "wb") as f:
            f.write(header(e) + content)

    # Version 7.3 is HDF5 behind a block of 512 bytes.
    def block(name):
        with open(out("matlab", name), "r+b") as f:
            f.write(b"MATLAB 7.3 MAT-file, Platform: by hand".ljust(116) + b"\0" * 8 + b"\x00\x02IM")

    def sparse(group, name, a, **options):
        a = a.tocsc()
        g = group.create_group(name)
        g.attrs["MATLAB_class"], g.attrs["MATLAB_sparse"] = np.bytes_("double"), np.uint64(a.shape[0])
        if a.nnz:
            g.create_dataset("data", data=a.data, **options)
            g.create_dataset("ir", data=a.indices.astype("u8"), **options)
        g.create_dataset("jc", data=a.indptr.astype("u8"))

    def full(group, name, a, cls="double", **options):
        d = group.create_dataset(name, data=np.ascontiguousarray(np.asarray(a).T), **options)
        d.attrs["MATLAB_class"] = np.bytes_(cls)
        return d

    with h5py.File(out("matlab", "variants_v73.mat"), "w", userblock_size=512, libver="earliest") as f:
        s = f.create_group("s")
        s.attrs["MATLAB_class"] = np.bytes_("struct")
        sparse(s, "K", k, chunks=(16,), compression="gzip", shuffle=True)
        full(s, "M", m.toarray(), chunks=(5, 5), compression="gzip")
        sparse(f, "nothing", sp.csc_matrix((4, 4)))
        full(f, "whole", whole.toarray().astype("i2"), "int16")
        full(f, "single", k.toarray().astype("f4"), "single")
        full(f, "dofs", dof_ref.astype(float))
        full(f, "dof_ref", dof_ref.astype("i8"), "int64")
        full(f, "nodes", np.arange(12.0).reshape(4, 3))
        full(f, "flags", np.eye(12, dtype="u1"), "logical").attrs["MATLAB_int_decode"] = np.int32(1)
        full(f, "z", np.zeros((3, 3), dtype=[("real", "f8"), ("imag", "f8")]))
        full(f, "title", np.frombuffer(b"part", "u1").astype("u2").reshape(1, -1), "char")
        refs = f.create_group("#refs#")
        full(refs, "a", k.toarray())
        c = f.create_dataset("cell", shape=(1, 1), dtype=h5py.ref_dtype)
        c[0, 0] = refs["a"].ref
        c.attrs["MATLAB_class"] = np.bytes_("cell")
    block("variants_v73.mat")
    with h5py.File(out("matlab", "variants_big_endian.h5"), "w") as f:
        f.create_dataset("K", data=k.toarray().astype(">f8"), chunks=(4, 6))
        g = f.create_group("system")
        g.create_dataset("data", data=m.data.astype(">f8"))
        g.create_dataset("indices", data=m.indices.astype(">i4"))
        g.create_dataset("indptr", data=m.indptr)


text()
for kind in sys.argv[1:]:
    {"numpy": numpy, "matlab": matlab, "petsc": petsc}[kind]()
