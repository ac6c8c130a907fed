"""Which runs count, and which modes they missed. Plain Python, from the numbers of `check_superelement.py`."""

MULTIPLICITY = 1e-6  # eigenvalues this close, relatively, are one
OF_MODES = dict(mode_residual=1e-6, orthonormality=1e-8, rigid_orthogonality=1e-5)
OF_THE_REST = dict(
    attachment_residual=1e-8, attachment_orthogonality=1e-8, flexibility_difference=1e-8, flexibility_asymmetry=1e-8,
    mass_difference=1e-8, inertia_difference=1e-9, coupling_difference=1e-8,
)
MODES_ONLY = ("slepc-mumps", "slepc-mumps-mpi", "exudyn")


def failures(run):
    """Names of the checks that are missing or beyond their bounds; a run with any doesn't count."""
    bounds = OF_MODES if run["tool"] in MODES_ONLY else OF_MODES | OF_THE_REST
    check = run.get("check") or {}
    return [name for name, bound in bounds.items() if name not in check or not check[name] <= bound]


def counts(run):
    return "failed" not in run and not failures(run)


def clusters(values):
    """Eigenvalues as (value, multiplicity), ascending."""
    found = []
    for value in sorted(values):
        if found and value - found[-1][0] <= MULTIPLICITY * value:
            found[-1][1] += 1
        else:
            found.append([value, 1])
    return found


def reference_values(lists):
    """The union of what all tools found: of each eigenvalue the largest multiplicity that any of them has."""
    union = {}
    for index, values in enumerate(lists):
        for value, multiplicity in clusters(values):
            union[value, index] = multiplicity
    found = []
    for (value, _), multiplicity in sorted(union.items()):
        if found and value - found[-1][0] <= MULTIPLICITY * value:
            found[-1][1] = max(found[-1][1], multiplicity)
        else:
            found.append([value, multiplicity])
    return [value for value, multiplicity in found for _ in range(multiplicity)]


def modes_missed(values, reference, wanted):
    """How many of the lowest `wanted` reference eigenvalues aren't among the values, counting multiplicity."""
    missed = 0
    for value, multiplicity in clusters(reference[:wanted]):
        near = sum(abs(found - value) <= 2 * MULTIPLICITY * value for found in values)
        missed += max(0, multiplicity - near)
    return missed
