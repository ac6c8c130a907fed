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
RPM = 2 * np.pi / 60
LENGTH, ELEMENTS, DIAMETER, STIFFNESS, DENSITY = 1.5, 12, 0.05, 1e6, 7810
DISKS = ((4, 0.28), (8, 0.35))      # node, outer diameter


def rotor_of_the_book():
    steel = rs.Material("steel", rho=DENSITY, E=211e9, G_s=81.2e9)
    element = rs.ShaftElement(L=LENGTH / ELEMENTS, idl=0, odl=DIAMETER, material=steel, shear_effects=False, rotary_inertia=False, gyroscopic=False)
    disks = [rs.DiskElement.from_geometry(n=node, material=steel, width=0.07, i_d=DIAMETER, o_d=outer) for node, outer in DISKS]
    bearings = [rs.BearingElement(n=node, kxx=STIFFNESS, cxx=0) for node in (0, ELEMENTS)]
    return rs.Rotor([element] * ELEMENTS, disks, bearings), disks


def whirl(rotor, speed):
    """Frequencies with their direction as a sign, Hz, without torsion and what moves along the axis."""
    modal = rotor.run_modal(speed=speed, num_modes=32)
    signs = {"Forward": 1.0, "Backward": -1.0}
    pairs = zip(modal.wd / (2 * np.pi), modal.whirl_direction())
    return sorted((signs[str(way)] * hertz for hertz, way in pairs if str(way) in signs and hertz > 1), key=abs)


def criticals(rotor, rpm, count):
    """(order, rpm) where one of the lowest `count` whirls of a direction has the frequency of the spin, between the speeds given."""
    found = []
    for sign in (1, -1):
        for index in range(count):
            above = lambda speed: [abs(hertz) for hertz in whirl(rotor, speed) if sign * hertz > 0][index] * 2 * np.pi - speed
            grid = np.asarray(rpm) * RPM
            values = [above(speed) for speed in grid]
            for a, b, left, right in zip(grid, grid[1:], values, values[1:]):
                if left > 0 >= right:
                    found.append((sign, brentq(above, a, b, xtol=1e-9) / RPM))
    return found


def main():
    rotor, disks = rotor_of_the_book()
    speeds = [500.0, 2000.0, 4000.0, 8000.0]
    table = [whirl(rotor, speed * RPM)[:8] for speed in speeds]
    with open("ross.json", "w") as file:
        json.dump({"ross": rs.__version__, "numpy": np.__version__,
                   "disks": [{"mass": disk.m, "diametral": disk.Id, "polar": disk.Ip} for disk in disks],
                   "rpm": speeds, "hertz": table,
                   "criticals": [{"order": order, "rpm": rpm} for order, rpm in criticals(rotor, np.linspace(200, 16000, 80), 3)]}, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main()
