"""The page's first example, as it is printed."""

import pathlib
import subprocess
import sys

import pytest

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"


def test_from_scikit_fem_to_a_picture(tmp_path):
    pytest.importorskip("skfem")
    picture = tmp_path / "pendulum.png"
    run = subprocess.run([sys.executable, EXAMPLES / "skfem_pendulum.py", picture], capture_output=True, text=True, env={"MPLBACKEND": "agg", "PATH": ""})
    assert run.returncode == 0, run.stderr
    assert "8 modes" in run.stdout and "complete" in run.stdout
    assert picture.stat().st_size > 10000


def test_meshio_takes_modes_and_gives_parts(tmp_path):
    meshio = pytest.importorskip("meshio")
    skfem = pytest.importorskip("skfem")
    import numpy as np
    import tisserand
    import tisserand.meshio
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    mesh = skfem.MeshTet.init_tensor(np.linspace(0, 1, 5), np.linspace(0, 0.2, 2), np.linspace(0, 0.2, 2))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP1()))
    stiffness = linear_elasticity(*lame_parameters(1e9, 0.3)).assemble(basis)
    mass = skfem.BilinearForm(lambda u, v, w: 1000.0 * dot(u, v)).assemble(basis)
    # By way of meshio, as from any mesher; rows node after node, as these elements have them.
    given = meshio.Mesh(mesh.p.T, [("tetra", mesh.t.T)], point_sets={"end": np.flatnonzero(mesh.p[0] < 1e-9)})
    ends = {"end": tisserand.meshio.nodes(given, "end")}
    part = tisserand.reduce(stiffness, mass, interfaces=ends, modes=4, **tisserand.meshio.arguments(given))
    path = tmp_path / "modes.vtu"
    tisserand.meshio.mesh(part, modes=[0, 3]).write(path)
    back = meshio.read(path)
    assert set(back.point_data) == {"mode 1", "mode 4"}
    assert np.array_equal(back.point_data["mode 4"], part.shape(3)) and back.cells[0].data.shape == mesh.t.T.shape
    with pytest.raises(tisserand.InputError, match="it has end"):
        tisserand.meshio.nodes(given, "hub")


@pytest.mark.parametrize("order", [1, 3])
def test_ngsolve_gives_parts_of_any_order(order):
    ngsolve = pytest.importorskip("ngsolve")
    import numpy as np
    import scipy.linalg
    import tisserand
    import tisserand.ngsolve
    from netgen.csg import CSGeometry, OrthoBrick, Pnt

    geometry = CSGeometry()
    geometry.Add(OrthoBrick(Pnt(0, 0, 0), Pnt(1, 0.2, 0.1)).bc("skin"))
    mesh = ngsolve.Mesh(geometry.GenerateMesh(maxh=0.3))
    space = ngsolve.VectorH1(mesh, order=order)
    u, v = space.TnT()
    strain = lambda w: 0.5 * (ngsolve.Grad(w) + ngsolve.Grad(w).trans)
    stress = 2 * 80e9 * strain(u) + 120e9 * ngsolve.Trace(strain(u)) * ngsolve.Id(3)
    stiffness = ngsolve.BilinearForm(ngsolve.InnerProduct(stress, strain(v)) * ngsolve.dx).Assemble()
    mass = ngsolve.BilinearForm(7800 * u * v * ngsolve.dx).Assemble()
    bar = tisserand.ngsolve.part(space)
    K, M = tisserand.ngsolve.matrix(stiffness), tisserand.ngsolve.matrix(mass)
    end = np.flatnonzero(bar.points[:, 0] < 1e-9)
    part = tisserand.reduce(K, M, interfaces={"end": end}, modes=4, **bar.arguments())
    values = scipy.linalg.eigh(K.toarray(), M.toarray(), eigvals_only=True)
    assert np.allclose(part.eigenvalues, values[6:10], rtol=1e-8)
    assert len(bar.nodes("skin")) > 8
    with pytest.raises(tisserand.InputError, match="it has skin"):
        bar.nodes("hub")
