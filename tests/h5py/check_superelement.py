#!/usr/bin/env python3
"""Checks a superelement FILE with h5py alone, as docs/format.md describes it.

Reads every dataset, asks for every required attribute, recomputes every sha256 and the digest, and compares all
shapes. Exits with 1 and one line per finding where something is wrong. It shares no code with the Rust reader.
"""

import hashlib
import json
import struct
import sys

import h5py
import numpy

REQUIRED = """
/frame/origin d | /interfaces/names i | /interfaces/kinds i | /interfaces/roles i | /interfaces/positions i,d
/interfaces/dofs b,2 | /interfaces/row_nodes b | /interfaces/row_positions b,d
/modes/eigenvalues k | /modes/damping k | /modes/interface_shapes b,k
/residual/flexibility b,b | /residual/mass b,b | /residual/mass_diagonal0 b | /residual/transform b,r
/residual/sigma2 r | /inertia/mass - | /inertia/L1 d,n
"""
PLANAR = "/interfaces/orientations i | /inertia/tensor - | /inertia/I1 n | /inertia/I3 n | /inertia/L3 n,n"
SPATIAL = """
/interfaces/orientations i,3,3 | /inertia/tensor 3,3 | /inertia/I1 n,3,3 | /inertia/I3 3,n
/inertia/L3 3,n,n | /inertia/I2 n,n,3,3
"""
OPTIONAL = """
/residual/output_shapes b,b | /enrichment/interface_shapes b,x | /enrichment/names x | /enrichment/shapes x,f | /reduced/mass n,n | /reduced/stiffness n,n
/error/forces b,p | /derivation/coupling_source - | /derivation/interface_directions 2 | /derivation/left_out_columns o
/derivation/selection_modes m,2 | /derivation/selection_first_omitted_eigenvalues s | /derivation/selection_frequency_limits s
/derivation/selection_forces b,v | /derivation/selection_force_interfaces v,2
/stiffening/interface b,n,n | /loads/names l | /loads/forces l,d | /loads/work l,n | /fields/dofs f,2 | /modes/shapes k,f | /residual/shapes b,f
"""
STRINGS = {"/interfaces/names", "/interfaces/kinds", "/interfaces/roles", "/enrichment/names", "/loads/names",
           "/derivation/coupling_source", "/derivation/left_out_columns"}
INTEGERS = {"/interfaces/dofs", "/interfaces/row_nodes", "/fields/dofs", "/derivation/interface_directions",
            "/derivation/selection_modes", "/derivation/selection_force_interfaces"}


def parse(table):
    rows = table.replace("\n", "|").split("|")
    return dict(row.split() for row in rows if row.strip())


def collect(file):
    """Every object by path, groups and datasets."""
    objects = {"/": file}
    file.visititems(lambda name, item: objects.__setitem__("/" + name, item))
    return objects


def content(dataset):
    """The dtype name and the bytes that are hashed."""
    if h5py.check_string_dtype(dataset.dtype):
        values = numpy.atleast_1d(dataset.asstr()[()]).ravel()
        return "str", "\n".join(values).encode()
    values = numpy.ascontiguousarray(dataset[()])
    return values.dtype.str, values.tobytes()


def text(value):
    """An attribute's string: h5py gives those of fixed length as bytes."""
    return value.decode() if isinstance(value, bytes) else value


def canonical(value):
    if isinstance(value, numpy.ndarray):
        return [canonical(entry) for entry in value.tolist()]
    if isinstance(value, (float, numpy.floating)):
        return struct.pack(">d", value).hex()
    if isinstance(value, (int, numpy.integer)):
        return int(value)
    return str(text(value))


def covered(path, item, name):
    if path == "/":
        return name not in ("digest", "generator")
    if path == "/provenance":
        return False
    return not (isinstance(item, h5py.Dataset) and name in ("description", "sha256"))


def digest(objects):
    total = hashlib.sha256()
    for path in sorted(objects, key=str.encode):
        item = objects[path]
        if isinstance(item, h5py.Dataset):
            dtype, data = content(item)
            shape = "(" + ",".join(map(str, item.shape)) + ")"
            total.update(f"{path} {dtype} {shape} {hashlib.sha256(data).hexdigest()}\n".encode())
    attributes = {}
    for path, item in objects.items():
        kept = {name: canonical(value) for name, value in item.attrs.items() if covered(path, item, name)}
        if kept:
            attributes[path] = kept
    covered_json = json.dumps(attributes, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    total.update(covered_json.encode())
    return total.hexdigest()


def check(file):
    found = []
    objects = collect(file)
    attrs = {name: text(value) for name, value in file.attrs.items()}
    for name in ("format", "format_version", "name", "dimension", "units", "generator", "digest"):
        if name not in attrs:
            found.append(f"/: attribute {name} is missing")
    if found:
        return found, 0
    if attrs["format"] != "dcb-superelement" or attrs["format_version"].split(".")[0] != "1":
        found.append(f"/: {attrs['format']} {attrs['format_version']}")
    if set(json.loads(attrs["units"])) != {"length", "mass", "time"}:
        found.append(f"/: units are {attrs['units']}")
    for path, name in (("/frame", "kind"), ("/modes", "first_omitted_eigenvalue"), ("/modes/damping", "residual"),
                       ("/residual/transform", "rank"), ("/residual/transform", "tolerance")):
        if name not in file[path].attrs:
            found.append(f"{path}: attribute {name} is missing")

    planar = attrs["dimension"] == 2
    sizes = {"d": 2 if planar else 3, "i": len(file["/interfaces/names"]), "b": len(file["/interfaces/dofs"]),
             "k": len(file["/modes/eigenvalues"]), "r": len(file["/residual/sigma2"]), "x": 0, "f": 0,
             "l": len(file["/loads/names"]) if "/loads/names" in file else 0}
    if "/enrichment/interface_shapes" in file:
        sizes["x"] = file["/enrichment/interface_shapes"].shape[1]
    if "/fields/dofs" in file:
        sizes["f"] = len(file["/fields/dofs"])
    for letter, path, axis in (("p", "/error/forces", 1), ("o", "/derivation/left_out_columns", 0),
                               ("s", "/derivation/selection_frequency_limits", 0), ("m", "/derivation/selection_modes", 0),
                               ("v", "/derivation/selection_forces", 1)):
        sizes[letter] = file[path].shape[axis] if path in file else 0
    sizes["n"] = sizes["k"] + sizes["b"] + sizes["x"]
    required = parse(REQUIRED) | parse(PLANAR if planar else SPATIAL)
    optional = parse(OPTIONAL) | {
        "/stiffening/centrifugal": ("1" if planar else "6") + ",n,n", "/loads/moments": "l" if planar else "l,3"}
    for path, axes in (required | optional).items():
        if path not in file:
            if path in required:
                found.append(f"{path}: is missing")
            continue
        shape = () if axes == "-" else tuple(sizes[axis] if axis in sizes else int(axis) for axis in axes.split(","))
        dtype = "str" if path in STRINGS else "<i8" if path in INTEGERS else "<f8"
        if file[path].shape != shape or content(file[path])[0] != dtype:
            found.append(f"{path}: is {file[path].dtype} {file[path].shape}, not {dtype} {shape}")

    count = 0
    for path, item in objects.items():
        if not isinstance(item, h5py.Dataset):
            continue
        count += 1
        for name in ("symbol", "units", "description", "sha256"):
            if name not in item.attrs:
                found.append(f"{path}: attribute {name} is missing")
        if text(item.attrs.get("units")) == "mixed" and "row_units" not in item.attrs:
            found.append(f"{path}: units are mixed, and row_units are missing")
        axes = ("layer_units", "row_units", "column_units") if path == "/stiffening/interface" else None
        for axis, name in enumerate(axes or ()):
            if name in item.attrs and len(item.attrs[name]) != item.shape[axis]:
                found.append(f"{path}: {name} has {len(item.attrs[name])} entries")
        data = content(item)[1]
        if hashlib.sha256(data).hexdigest() != text(item.attrs.get("sha256")):
            found.append(f"{path}: sha256 differs")
    if digest(objects) != attrs["digest"]:
        found.append("/: digest differs")
    return found, count


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with h5py.File(sys.argv[1], "r") as file:
        found, count = check(file)
    for finding in found:
        print(f"{sys.argv[1]}: {finding}", file=sys.stderr)
    if found:
        sys.exit(1)
    print(f"{sys.argv[1]}: {count} datasets, every sha256 and the digest are right")


if __name__ == "__main__":
    main()
