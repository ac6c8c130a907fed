"""A matrix in the files of many programs, as `read_matrices.py` reads them.

Each writer takes a path, the number of rows, and the lower triangle column after column: rows, columns (0-based), values. Numbers have 16 or
17 digits, but for the formats that never have (CalculiX 14, Nastran's punch 10).
"""

import struct

import h5py
import numpy as np
import scipy.io
import scipy.sparse


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
    kind = "RSA" if (rows >= columns).all() else "RUA"
    widths = (8, 8, 25) if fields[0] > 1 else (14, 14, 25)
    digits = 16 if letter == "E" else 15
    starts = np.concatenate(([0], np.cumsum(np.bincount(columns, minlength=size))))
    counts = [-(-count // per) for count, per in zip((size + 1, rows.size, rows.size), fields)]
    with open(path, "w") as file:
        file.write("%-72s%-8s\n" % ("stencil", "KEY") + "".join("%14d" % count for count in (sum(counts), *counts, 0)) + "\n")
        file.write(f"{kind}           " + "".join("%14d" % count for count in (size, size, rows.size, 0)) + f"\n{formats}\n")
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


def harwell_boeing_full(path, size, *lower):
    # SciPy takes no scale factor in a format.
    harwell_boeing(path, size, *full(*lower), formats="(10I8)          (10I8)          (3E25.16)")


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


def symmetric(size, rows, columns, values):
    """Both triangles in SciPy's compressed rows."""
    rows, columns, values = full(rows, columns, values)
    return scipy.sparse.csr_matrix((values, (rows, columns)), (size, size))


def npz(path, *matrix):
    scipy.sparse.save_npz(path, symmetric(*matrix), compressed=False)


def npz_coo(path, *matrix):
    scipy.sparse.save_npz(path, symmetric(*matrix).tocoo(), compressed=False)


def npz_deflated(path, *matrix):
    scipy.sparse.save_npz(path, symmetric(*matrix))


def npy_dense(path, *matrix):
    np.save(path, symmetric(*matrix).toarray())


def mat5(path, *matrix):
    scipy.io.savemat(path, {"K": symmetric(*matrix).tocsc()}, appendmat=False)


def mat5_deflated(path, *matrix):
    scipy.io.savemat(path, {"K": symmetric(*matrix).tocsc()}, appendmat=False, do_compression=True)


def mat73(path, *matrix, **storage):
    """As MATLAB writes it: a group with `data`, `ir`, `jc` behind a header of 512 bytes."""
    k = symmetric(*matrix).tocsc()
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("K")
        group.attrs["MATLAB_class"], group.attrs["MATLAB_sparse"] = np.bytes_("double"), np.uint64(k.shape[0])
        group.create_dataset("data", data=k.data, **storage)
        group.create_dataset("ir", data=k.indices.astype("u8"), **storage)
        group.create_dataset("jc", data=k.indptr.astype("u8"))
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def mat73_deflated(path, *matrix):
    mat73(path, *matrix, chunks=(1 << 16,), compression=3)


def petsc(path, *matrix):
    k = symmetric(*matrix)
    with open(path, "wb") as file:
        np.array([1211216, *k.shape, k.nnz], ">i4").tofile(file)
        np.diff(k.indptr).astype(">i4").tofile(file)
        k.indices.astype(">i4").tofile(file)
        k.data.astype(">f8").tofile(file)
