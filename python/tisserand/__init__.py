"""Finite-element parts to superelements, and the motion of mechanisms made of them.

:func:`reduce` turns stiffness and mass into a :class:`Superelement`; :class:`Scene` describes a mechanism of superelements and rigid bodies;
:func:`simulate` runs it, and :class:`Mechanism` steps it under the control of a program;
:func:`linearize` gives its linear system about a state.
"""

from tisserand._native import Error, InputError, InternalError, NumericalError, Snapshot, __version__
from tisserand.linear import LinearSystem, Truncation, linearize
from tisserand.mechanism import History, Mechanism
from tisserand.reduction import Plan, plan, reduce
from tisserand.results import Channel, Results
from tisserand.scene import Scene
from tisserand.simulation import simulate
from tisserand.study import Study, study
from tisserand.superelement import ErrorBounds, Superelement, Verification

__all__ = [
    "Channel",
    "Error",
    "ErrorBounds",
    "History",
    "InputError",
    "InternalError",
    "LinearSystem",
    "Mechanism",
    "NumericalError",
    "Plan",
    "Results",
    "Scene",
    "Snapshot",
    "Study",
    "Superelement",
    "Truncation",
    "Verification",
    "__version__",
    "linearize",
    "plan",
    "reduce",
    "simulate",
    "study",
]
