"""Universal files of a known vibration through the converter of docs/measured.md: shapes (dataset 55, real and complex) and accelerances (dataset 58) must give its modes back.

    python3 universal_files.py CONVERTER FOLDER
"""
import csv
import os
import subprocess
import sys

import numpy as np
import pyuff

converter, folder = sys.argv[1:]
NODES = [1, 2, 3, 4]
FREQUENCIES, RATIOS = [120.0, 310.0], [0.004, 0.011]
SHAPES = np.random.default_rng(7).normal(size=(2, len(NODES), 3))


def write(name, sets):
    path = os.path.join(folder, name)
    file = pyuff.UFF(path)
    for one in sets:
        file.write_sets([one], mode="add")
    return path


def converted(path, *peaks):
    target = os.path.join(folder, "modes.csv")
    subprocess.run([sys.executable, converter, path, target, "1", *map(str, peaks)], check=True)
    with open(target) as file:
        head, *rows = list(csv.reader(file))
    assert head[:2] == ["frequency [Hz]", "damping"], head
    return head[2:], np.array([[float(value) for value in row] for row in rows])


def check(what, places, rows, tolerance):
    assert np.allclose(rows[:, 0], FREQUENCIES, rtol=tolerance), (what, rows[:, 0])
    assert np.allclose(rows[:, 1], RATIOS, rtol=10 * tolerance), (what, rows[:, 1])
    for mode, row in enumerate(rows[:, 2:]):
        expected = np.array([SHAPES[mode][int(place.split(".")[0])]["xyz".index(place[-1])] for place in places])
        mac = abs(row @ expected) ** 2 / ((row @ row) * (expected @ expected))
        assert mac > 1 - 10 * tolerance, (what, mode, mac)


def shape(mode, is_complex):
    pole = 2 * np.pi * FREQUENCIES[mode] * complex(-RATIOS[mode], np.sqrt(1 - RATIOS[mode] ** 2))
    turn = np.exp(0.7j) if is_complex else 1.0
    parts = {f"r{axis + 1}": turn * SHAPES[mode][:, axis] for axis in range(3)}
    common = {"type": 55, "id1": "", "id2": "", "id3": "", "id4": "", "id5": "", "model_type": 1, "data_ch": 2, "spec_data_type": 8, "load_case": 1, "mode_n": mode + 1,
              "n_data_per_node": 3, "node_nums": NODES, **parts}
    if is_complex:
        return {**common, "analysis_type": 3, "data_type": 5, "eig": pole, "modal_a": 1 + 0j, "modal_b": 1 + 0j}
    return {**common, "analysis_type": 2, "data_type": 2, "freq": FREQUENCIES[mode], "modal_m": 1.0, "modal_damp_vis": RATIOS[mode], "modal_damp_his": 0.0}


for is_complex in (False, True):
    path = write(f"shapes-{is_complex}.uff", [shape(mode, is_complex) for mode in range(2)])
    check(f"shapes, complex: {is_complex}", *converted(path), 1e-4)

# Accelerances of all places by a force at the first.
hertz = np.arange(0.0, 500.0, 0.125)
omega = 2 * np.pi * hertz
sets = []
for place, node in enumerate(NODES):
    for axis in range(3):
        receptance = sum(SHAPES[mode][place, axis] * SHAPES[mode][0, 0] / ((2 * np.pi * FREQUENCIES[mode]) ** 2 - omega**2 + 2j * RATIOS[mode] * 2 * np.pi * FREQUENCIES[mode] * omega) for mode in range(2))
        sets.append({"type": 58, "func_type": 4, "rsp_node": node, "rsp_dir": axis + 1, "ref_node": 1, "ref_dir": 1, "data": -(omega**2) * receptance, "x": hertz, "id1": "", "rsp_ent_name": "part", "ref_ent_name": "part",
                     "abscissa_spacing": 1, "abscissa_spec_data_type": 18, "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 13})
check("accelerances", *converted(write("responses.uff", sets), *FREQUENCIES), 1e-3)
print("ok")
