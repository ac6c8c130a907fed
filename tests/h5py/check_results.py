#!/usr/bin/env python3
"""Checks a results FILE with h5py alone, as docs/results.md describes it, and prints a summary as JSON.

Exits with 1 and one line per finding where something is wrong. It shares no code with the Rust reader.
"""

import json
import sys

import h5py
import numpy


def text(value):
    return value.decode() if isinstance(value, bytes) else value


def main(path):
    findings = []
    with h5py.File(path, "r") as file:
        attributes = file.attrs
        if text(attributes["format"]) != "dcb-results":
            findings.append("/: format")
        if text(attributes["format_version"]).split(".")[0] != "1":
            findings.append("/: format_version")
        if set(json.loads(attributes["units"])) != {"length", "mass", "time"}:
            findings.append("/: units")
        if not isinstance(attributes["complete"], (bool, numpy.bool_)):
            findings.append("/: complete isn't a bool")
        stopped = json.loads(attributes["stopped"])
        if (stopped is None) != bool(attributes["complete"]):
            findings.append("/: complete and stopped disagree")
        time = file["time"][...]
        if time.dtype != "<f8" or time.ndim != 1 or not (numpy.diff(time) > 0).all():
            findings.append("/time")
        channels = {}

        def visit(name, item):
            # Channels have two axes; what names their axes has one.
            if not isinstance(item, h5py.Dataset) or item.ndim != 2:
                return
            columns = [text(column) for column in item.attrs["columns"]]
            if item.shape != (len(time), len(columns)) or item.dtype != "<f8":
                findings.append(f"/{name}: shape {item.shape}, type {item.dtype}")
            units = text(item.attrs["units"])
            if units == "mixed" and len(item.attrs["column_units"]) != len(columns):
                findings.append(f"/{name}: column_units")
            text(item.attrs["description"])
            channels[name] = {"columns": columns, "units": units, "sum": item[...].sum(axis=0).tolist()}

        file.visititems(visit)
        provenance = {name: text(value) for name, value in file["provenance"].attrs.items()}
        for name in ("scene", "inputs", "options", "warnings"):
            json.loads(provenance[name])
        summary = {"complete": bool(attributes["complete"]), "stopped": stopped, "steps": len(time), "channels": channels}
    for finding in findings:
        print(finding, file=sys.stderr)
    print(json.dumps(summary, sort_keys=True))
    return bool(findings)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
