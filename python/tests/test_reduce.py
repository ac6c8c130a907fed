"""Reductions of matrices in memory, against the program, SciPy and closed forms."""

import gc
import json
import os
import pathlib
import signal
import subprocess
import sys

import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.sparse as sparse
import tisserand

REPOSITORY = pathlib.Path(os.environ.get("TISSERAND_REPOSITORY", pathlib.Path(__file__).resolve().parents[2]))
DATA = REPOSITORY / "tests/data/exchange"


@pytest.fixture(scope="module")
def bracket():
    description = json.loads((DATA / "bracket.json").read_text())
    component = description["component"]
    return {
        "K": scipy.io.mmread(DATA / "bracket.mtx").tocsr(),
        "M": scipy.io.mmread(DATA / "bracket.mass.mtx").tocsr(),
        "points": np.array(description["points"]),
        "interfaces": [
            {key: value for key, value in interface.items() if key != "point_set"} | {"nodes": description["point_sets"][interface["point_set"]]}
            for interface in component["interfaces"]
        ],
        "cells": {block["type"]: np.array(block["data"]) for block in description["cells"]},
        "name": component["name"],
        "units": tuple(component["units"][key] for key in ("length", "mass", "time")),
        "damping": component.get("damping"),
        "dofs": component["dofs"],
    }


@pytest.fixture(scope="module")
def reduced(bracket):
    return tisserand.reduce(**bracket, modes=10)


def solid(count):
    """A block of linear bricks of steel with this number of them along each edge."""
    from skfem import Basis, BilinearForm, ElementHex1, ElementVector, MeshHex
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity
    from tisserand.skfem import part

    mesh = MeshHex.init_tensor(*(np.linspace(0, 0.01 * n, n + 1) for n in count))
    basis = Basis(mesh, ElementVector(ElementHex1()))
    block = part(basis)
    return {
        "K": linear_elasticity(*lame_parameters(210e9, 0.3)).assemble(basis),
        "M": BilinearForm(lambda u, v, w: 7850.0 * dot(u, v)).assemble(basis),
        "interfaces": {"end": block.nodes(lambda x: abs(x[0]) < 1e-9)},
        **block.arguments(),
    }


def test_modes_are_those_of_scipy(bracket, reduced):
    values = scipy.linalg.eigh(bracket["K"].toarray(), bracket["M"].toarray(), eigvals_only=True)
    assert np.allclose(reduced.eigenvalues, values[6:16], rtol=1e-9)
    assert np.allclose(reduced.frequencies, np.sqrt(values[6:16]) / (2 * np.pi), rtol=1e-9)


def test_it_is_bit_for_bit_what_the_program_makes(reduced, tmp_path):
    target = tmp_path / "bracket.dcb.h5"
    command = [sys.executable, "-c", "from tisserand._programs import reduce; raise SystemExit(reduce())"]
    subprocess.run([*command, str(DATA / "bracket.mtx"), "--modes", "10", "-o", str(target), "-q"], check=True)
    of_program = tisserand.Superelement.read(target)
    for name in ("eigenvalues", "interface_shapes", "residual_flexibility", "residual_mass", "modes", "attachments", "points"):
        assert np.array_equal(getattr(of_program, name), getattr(reduced, name)), name
    assert of_program.rows == reduced.rows and of_program.mass == reduced.mass


@pytest.mark.parametrize("form", ["csc", "coo", "csr", "dense", "bsr", "array"])
@pytest.mark.parametrize("indices", [np.int32, np.int64])
def test_every_form_of_a_matrix_is_the_same(bracket, reduced, form, indices):
    def converted(matrix):
        if form == "dense":
            return matrix.toarray()
        made = sparse.csr_array(matrix) if form == "array" else matrix.asformat(form)
        if hasattr(made, "indptr"):
            made.indptr, made.indices = made.indptr.astype(indices), made.indices.astype(indices)
        return made

    same = tisserand.reduce(**bracket | {"K": converted(bracket["K"]), "M": converted(bracket["M"])}, modes=10)
    assert np.array_equal(same.eigenvalues, reduced.eigenvalues)


def test_unsorted_and_repeated_entries_are_summed_and_the_callers_matrix_stays(bracket, reduced):
    coo = bracket["K"].tocoo()
    order = np.random.default_rng(1).permutation(coo.nnz)
    twice = [np.concatenate([part[order], part[order]]) for part in (coo.row, coo.col)]
    values = np.concatenate([0.25 * coo.data[order], 0.75 * coo.data[order]])
    scattered = sparse.coo_matrix((values, tuple(twice)), coo.shape)
    assert np.allclose(tisserand.reduce(**bracket | {"K": scattered}, modes=10).eigenvalues, reduced.eigenvalues, rtol=1e-10)
    unsorted = bracket["K"].copy()
    for line in range(unsorted.shape[0]):
        run = slice(unsorted.indptr[line], unsorted.indptr[line + 1])
        unsorted.indices[run], unsorted.data[run] = unsorted.indices[run][::-1].copy(), unsorted.data[run][::-1].copy()
    unsorted.has_sorted_indices = False
    unsorted.has_canonical_format = False
    before = unsorted.indices.copy()
    assert np.array_equal(tisserand.reduce(**bracket | {"K": unsorted}, modes=10).eigenvalues, reduced.eigenvalues)
    assert np.array_equal(unsorted.indices, before)


def test_arrays_are_read_only_and_outlive_their_superelement(bracket):
    made = tisserand.reduce(**bracket, modes=4)
    shapes, expected = made.interface_shapes, made.interface_shapes.copy()
    del made
    gc.collect()
    tisserand.reduce(**bracket, modes=5)
    assert np.array_equal(shapes, expected)
    with pytest.raises(ValueError, match="read-only"):
        shapes[0, 0] = 1.0


def test_strided_arrays_are_the_same(bracket, reduced):
    wide = np.zeros((2 * len(bracket["points"]), 6))
    wide[::2, 1::2] = bracket["points"]
    stiffness = np.asfortranarray(bracket["K"].toarray())
    spread = np.zeros((stiffness.shape[0], 2 * stiffness.shape[1]))
    spread[:, ::2] = stiffness
    same = tisserand.reduce(**bracket | {"K": spread[:, ::2], "points": wide[::2, 1::2]}, modes=10)
    assert np.array_equal(same.eigenvalues, reduced.eigenvalues)


def test_arrays_that_change_or_go_during_a_reduction_have_no_influence(bracket, reduced):
    own = {"K": bracket["K"].copy(), "M": bracket["M"].copy(), "points": bracket["points"].copy()}

    def spoil(stage, share):
        for name in list(own):
            array = own.pop(name)
            (array if name == "points" else array.data)[:] = np.nan
        gc.collect()

    same = tisserand.reduce(**bracket | own, modes=10, progress=spoil)
    assert not own and np.array_equal(same.eigenvalues, reduced.eigenvalues)


def test_files_come_back(reduced, tmp_path):
    path = tmp_path / "part.dcb.h5"
    reduced.write(path)
    back = tisserand.Superelement.read(path)
    assert np.array_equal(back.modes, reduced.modes) and np.array_equal(back.field_dofs, reduced.field_dofs)
    with pytest.raises(tisserand.InputError, match="exists already"):
        reduced.write(path)
    reduced.write(path, overwrite=True, fields=False, mesh=False)
    bare = tisserand.Superelement.read(path)
    assert bare.modes is None and bare.points is None
    with pytest.raises(tisserand.InputError, match="no nodal fields"):
        bare.shape(0)


def test_errors_checks_and_selection(reduced, bracket):
    bounds = reduced.errors()
    assert bounds.static_response[1] < 1e-6 and bounds.collocated[0] <= bounds.collocated[1]
    assert reduced.errors(reduced.frequencies[3]).collocated[1] <= bounds.collocated[1]
    assert reduced.verify() and reduced.verify().broken == []
    fewer = reduced.select(modes=4)
    direct = tisserand.reduce(**bracket, modes=4)
    ours, theirs = fewer.errors(), direct.errors()
    assert np.allclose(ours.collocated, theirs.collocated, rtol=0.05) and np.allclose(ours.transfer, theirs.transfer, rtol=0.05)
    assert np.allclose(fewer.residual_flexibility, direct.residual_flexibility, rtol=1e-8, atol=1e-12 * abs(direct.residual_flexibility).max())


def test_inspection_comparison_and_plan(reduced, bracket):
    assert reduced.inspect()["name"] == reduced.name
    fewer = reduced.select(modes=4)
    assert "mass" in reduced.compare(fewer)
    known = {key: value for key, value in bracket.items() if key in ("K", "M", "points", "interfaces", "dofs", "units")}
    cost = tisserand.plan(**known, modes=10)
    assert cost.dofs == 240 and cost.modes == 10 and cost.attachments == len(reduced.rows) and cost.memory > 1e6


def test_progress_is_told_and_what_it_raises_is_passed_on(bracket):
    told = []
    tisserand.reduce(**bracket, modes=4, progress=lambda stage, share: told.append((stage, share)))
    assert {"model", "factor", "modes", "attachments"} <= {stage for stage, _ in told}

    def raises(stage, share):
        raise KeyError(stage)

    with pytest.raises(KeyError):
        tisserand.reduce(**bracket, modes=4, progress=raises)


@pytest.mark.parametrize("threads", [None, 1])
def test_ctrl_c_ends_a_reduction_soon(threads, keyboard):
    count = (40, 12, 12)
    part = solid(count)
    told = []

    def press(stage, share):
        told.append(stage)
        if stage == "modes" and told.count("modes") == 3:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        tisserand.reduce(**part, modes=60, threads=threads, progress=press)
    assert "attachments" not in told, told
    # The next one isn't touched by it.
    assert tisserand.reduce(**part, modes=1).eigenvalues.size >= 1


def test_a_study_names_the_cheapest_reduction(bracket, tmp_path):
    study = tisserand.study(**bracket, modes=[2, 6], forms=["strong", "static"], band_points=50, output=tmp_path / "study")
    assert [(row["variant"], row["modes"]) for row in study.rows if not row["enrichment"]] == [
        ("strong", 2), ("static", 2), ("strong", 6), ("static", 6)
    ]
    table = study.to_pandas()
    strong = table[(table.variant == "strong") & table.further_columns.isna()].set_index("modes")
    assert strong.collocated[6] < strong.collocated[2] < 1 and strong.held_frequencies[6] < strong.held_frequencies[2]
    assert "strong" in str(study) and (tmp_path / "study/report.html").stat().st_size > 10_000
    assert len(table) == len(study.rows)
    with pytest.raises(tisserand.InputError, match="has files in it"):
        tisserand.study(**bracket, output=tmp_path / "study")
    with pytest.raises(tisserand.InputError, match="strong"):
        tisserand.study(**bracket, forms=["stronk"])
    assert {row["variant"] for row in tisserand.study(**bracket, modes=[2], forms=["static"], band_points=20).rows} == {"static"}


def test_memory_is_kept_to(bracket, tmp_path):
    whole = tisserand.reduce(**bracket, modes=4)
    for factor in ("memory", "disk"):
        other = tisserand.reduce(**bracket, modes=4, factor=factor, scratch=tmp_path, memory="1G")
        assert np.array_equal(other.modes, whole.modes), factor
    with pytest.raises(tisserand.InputError, match="not enough memory"):
        tisserand.reduce(**bracket, modes=4, memory="1K")
    with pytest.raises(tisserand.InputError, match="8G"):
        tisserand.reduce(**bracket, modes=4, memory="lots")
    with pytest.raises(tisserand.InputError, match="expected one of auto"):
        tisserand.reduce(**bracket, modes=4, factor="floppy")


def changed(matrix, row, column, value):
    made = matrix.tolil(copy=True)
    made[row, column] = value
    return made.tocsr()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda part: {"K": part["K"][:, :-1]}, "expected a square matrix"),
        (lambda part: {"K": part["K"].astype(complex)}, "complex128, expected real numbers"),
        (lambda part: {"K": changed(part["K"], 3, 3, np.nan)}, r"K: the entry \(3, 3\) isn't finite"),
        (lambda part: {"K": changed(part["K"], 0, 5, 1e9)}, "symmetric"),
        (lambda part: {"K": "bracket.mtx"}, "expected real numbers"),
        (lambda part: {"M": part["M"][:-3, :-3]}, "mass"),
        (lambda part: {"points": part["points"][:-1], "cells": None}, "matrix has 240 rows"),
        (lambda part: {"points": part["points"].ravel()}, "expected two axes"),
        (lambda part: {"interfaces": {"hub": [0, 1, 999]}}, "999"),
        (lambda part: {"interfaces": {"hub": {"nodes": [0], "knd": "rigid"}}}, "knd"),
        (lambda part: {"units": ("m", "kg", "")}, "units"),
        (lambda part: {"damping": float("nan")}, "a number that isn.t finite"),
        (lambda part: {"modes": -1}, "modes: is -1, expected a whole number from 0 on"),
        (lambda part: {"cells": {"tetra": [[0, 1, 2, 80]]}}, "80"),
    ],
)
def test_what_cant_be_used_is_told(bracket, change, told):
    with pytest.raises(tisserand.InputError, match=told) as raised:
        tisserand.reduce(**bracket | {"modes": 4} | change(bracket))
    assert raised.value.variant and not str(raised.value).endswith("\n")


def test_numerical_failures_and_held_parts_are_exceptions(bracket):
    held = bracket["K"] + sparse.diags_array(np.full(240, 1e-3 * bracket["K"].diagonal().max()))
    with pytest.raises(tisserand.Error):
        tisserand.reduce(**bracket | {"K": held}, modes=4)
    assert issubclass(tisserand.NumericalError, tisserand.Error) and not issubclass(tisserand.NumericalError, tisserand.InputError)
