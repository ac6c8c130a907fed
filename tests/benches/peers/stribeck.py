"""Stick and slip of a block on a belt, by SciPy: numbers that `tests/dynamics/scenes/actuators.rs` compares with.

A block of 1 kg on a spring of 40 N/m is carried along at 0.1 m/s; friction 2 N in motion, 3 N at rest, with a Stribeck rate of 0.05 m/s and a
regularization of 1e-3 m/s. The spring's end moves, as a servo's target does. Printed: places of the block.
"""

import numpy as np
from scipy.integrate import solve_ivp

MASS, STIFFNESS, SPEED = 1.0, 40.0, 0.1
COULOMB, AT_REST, STRIBECK, REGULARIZATION = 2.0, 3.0, 0.05, 1e-3


def rates(t: float, state: np.ndarray) -> list[float]:
    x, v = state
    dry = COULOMB + (AT_REST - COULOMB) * np.exp(-((v / STRIBECK) ** 2))
    force = STIFFNESS * (SPEED * t - x) - dry * np.tanh(v / REGULARIZATION)
    return [v, force / MASS]


times = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
found = solve_ivp(rates, (0, 3), [0.0, 0.0], method="Radau", t_eval=times, rtol=1e-11, atol=1e-13)
for time, place, rate in zip(found.t, *found.y):
    print(f"{time:.1f} {place:.10f} {rate:.10f}")
