#!/usr/bin/env python3
"""Opens a results FILE with xarray alone and prints what its groups look like, as JSON."""

import json
import sys

import h5py
import numpy
import xarray


def summary(dataset):
    lists = {name: values.values for name, values in dataset.coords.items() if values.ndim == 1}
    coordinates = {name: [one if isinstance(one, str) else float(one) for one in values] for name, values in lists.items()}
    variables = {
        name: {"dims": list(values.dims), "units": values.attrs.get("units"), "sum": float(numpy.nansum(values.values))}
        for name, values in dataset.variables.items()
        if name not in lists
    }
    return {"coordinates": coordinates, "variables": variables}


def main(path):
    found = {}
    with xarray.open_datatree(path, engine="h5netcdf") as tree:
        for group in tree.groups:
            found[group] = summary(tree[group].to_dataset())
    for group in list(found):
        with xarray.open_dataset(path, engine="h5netcdf", group=group) as dataset:
            alone = summary(dataset)
            if alone["variables"] != found[group]["variables"]:
                raise SystemExit(f"{group}: {alone} alone, {found[group]} in the tree")
            found[group]["alone"] = alone["coordinates"]
    # The high-level library agrees on who is a scale and who belongs to it.
    with h5py.File(path) as file:
        scales = {}

        def visit(name, item):
            if isinstance(item, h5py.Dataset):
                axes = [axis[0].name if len(axis) else None for axis in item.dims]
                attached = [h5py.h5ds.is_attached(item.id, item.dims[k][0].id, k) for k in range(item.ndim) if len(item.dims[k])]
                scales[name] = {"is_scale": item.is_scale, "axes": axes, "attached": attached}

        file.visititems(visit)
    print(json.dumps({"groups": found, "datasets": scales}))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
