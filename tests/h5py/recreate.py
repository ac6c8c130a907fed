#!/usr/bin/env python3
"""Copies the superelement FILE to COPY as another program could have written it with h5py: same contents, other layout.

    recreate.py FILE COPY default      h5py's defaults: superblock 0, old object headers, symbol tables
    recreate.py FILE COPY v114         the newest format before HDF5 2.0; every array in chunks, deflated and shuffled
    recreate.py FILE COPY fixed        strings of fixed length, also in attributes; chunks without filters
    recreate.py FILE COPY extended     defaults, and what a later minor version could add: datasets, groups, attributes
"""

import hashlib
import importlib.util
import pathlib
import sys

import h5py
import numpy


def fixed(texts):
    """Strings as an array of bytes with a fixed length."""
    data = numpy.array([text.encode() for text in numpy.atleast_1d(texts)])
    width = max(1, data.dtype.itemsize)
    return data.astype(h5py.string_dtype("utf-8", width))


def copy_attributes(source, target, variant):
    for name, value in source.attrs.items():
        if variant == "fixed" and isinstance(value, str):
            target.attrs.create(name, fixed(value)[0], dtype=h5py.string_dtype("utf-8", max(1, len(value.encode()))))
        elif variant == "fixed" and isinstance(value, numpy.ndarray) and value.dtype.kind == "O":
            target.attrs.create(name, fixed(value))
        else:
            target.attrs[name] = value


def copy_dataset(source, group, name, variant):
    if h5py.check_string_dtype(source.dtype):
        texts = source.asstr()[()]
        if variant == "fixed":
            data = fixed(texts)
            return group.create_dataset(name, data=data.reshape(source.shape), dtype=data.dtype)
        return group.create_dataset(name, data=texts, dtype=h5py.string_dtype())
    if variant == "v114" and source.size:
        if source.ndim:
            chunks = tuple(max(1, (length + 1) // 2) for length in source.shape)
            return group.create_dataset(name, data=source[()], chunks=chunks, compression="gzip", shuffle=True)
    if variant == "fixed" and source.size and source.ndim:
        return group.create_dataset(name, data=source[()], chunks=True, maxshape=(None,) * source.ndim)
    return group.create_dataset(name, data=source[()])


def extend(copy):
    data = numpy.arange(6.0).reshape(2, 3)
    later = copy.create_dataset("later/stresses", data=data, chunks=(1, 3), compression="gzip")
    later.attrs.update({"symbol": "s", "units": "1", "description": "later", "sha256": hashlib.sha256(data.tobytes()).hexdigest()})
    later.attrs["limits"] = [0.5, 1.5]
    copy["later"].attrs["counts"] = numpy.array([1, 2, 3])
    copy.attrs["format_version"] = "1.7"
    for index in range(40):
        copy["inertia"].attrs[f"note {index}"] = "x" * index


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    source, target, variant = sys.argv[1:]
    libver = ("v114", "v114") if variant == "v114" else None
    with h5py.File(source, "r") as file, h5py.File(target, "w", libver=libver) as copy:
        copy_attributes(file, copy, variant)

        def visit(name, item):
            if isinstance(item, h5py.Dataset):
                made = copy_dataset(item, copy, name, variant)
            else:
                made = copy.require_group(name)
            copy_attributes(item, made, variant)

        file.visititems(visit)
        if variant == "extended":
            extend(copy)
            path = pathlib.Path(__file__).with_name("check_superelement.py")
            spec = importlib.util.spec_from_file_location("check_superelement", path)
            checker = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(checker)
            copy.attrs["digest"] = checker.digest(checker.collect(copy))


main()
