"""Whirl of the rotor of example 5.9.1 in Friswell, Penny, Garvey and Lees, "Dynamics of Rotating Machines" (2010), by ROSS: writes ross.json.

    pip install ross-rotordynamics "plotly<6"
    python3 with_ross.py

A shaft of 1.5 m and 50 mm of Euler-Bernoulli elements without rotary inertia, two rigid disks, and two equal bearings of 1 MN/m. The book has Timoshenko elements; these are slender.
"""
import json
import warnings

import numpy as np
import ross as rs
from scipy.optimize import brentq

warnings.filterwarnings("ignore")
STEEL = rs.Material("steel", rho=7810, E=211e9, G_s=81.2e9)
LENGTH, ELEMENTS, DIAMETER, STIFFNESS = 1.5, 12, 0.05, 1e6

shaft = [rs.ShaftElement(L=LENGTH / ELEMENTS, idl=0, odl=DIAMETER, material=STEEL, shear_effects=False, rotary_inertia=False, gyroscopic=False)] * ELEMENTS
disks = [rs.DiskElement.from_geometry(n=node, material=STEEL, width=0.07, i_d=DIAMETER, o_d=outer) for node, outer in ((4, 0.28), (8, 0.35))]
bearings = [rs.BearingElement(n=node, kxx=STIFFNESS, cxx=0) for node in (0, ELEMENTS)]
rotor = rs.Rotor(shaft, disks, bearings)


def whirl(speed):
    """Frequencies with their direction as a sign, Hz, without torsion and what moves along the axis."""
    modal = rotor.run_modal(speed=speed, num_modes=32)
    signs = {"Forward": 1.0, "Backward": -1.0}
    pairs = zip(modal.wd / (2 * np.pi), modal.whirl_direction())
    return sorted((signs[str(way)] * hertz for hertz, way in pairs if str(way) in signs and hertz > 1), key=abs)


rpm = 2 * np.pi / 60
speeds = [500.0, 2000.0, 4000.0, 8000.0]
table = [whirl(speed * rpm)[:8] for speed in speeds]
criticals = []
for sign in (1, -1):
    for index in range(3):
        of = lambda speed: [abs(hertz) for hertz in whirl(speed) if sign * hertz > 0][index] * 2 * np.pi - speed
        grid = np.linspace(200, 16000, 80) * rpm
        values = [of(speed) for speed in grid]
        for a, b, left, right in zip(grid, grid[1:], values, values[1:]):
            if left > 0 >= right:
                criticals.append({"order": sign, "rpm": brentq(of, a, b, xtol=1e-9) / rpm})
with open("ross.json", "w") as file:
    json.dump({"ross": rs.__version__, "numpy": np.__version__,
               "disks": [{"mass": disk.m, "diametral": disk.Id, "polar": disk.Ip} for disk in disks],
               "rpm": speeds, "hertz": table, "criticals": criticals}, file, indent=1)
    file.write("\n")
