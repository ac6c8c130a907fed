"""Modes and moving mechanisms as pictures."""

import numpy as np
import pytest
import tisserand

pyvista = pytest.importorskip("pyvista")
skfem = pytest.importorskip("skfem")

from skfem.helpers import dot  # noqa: E402
from skfem.models.elasticity import lame_parameters, linear_elasticity  # noqa: E402
from tisserand.pyvista import animate, fields, mode  # noqa: E402
from tisserand.skfem import part  # noqa: E402


@pytest.fixture(scope="module")
def arm():
    mesh = skfem.MeshHex.init_tensor(np.linspace(0, 1, 11), np.linspace(-0.02, 0.02, 2), np.linspace(-0.01, 0.01, 2))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex1()))
    stiffness = linear_elasticity(*lame_parameters(70e9, 0.3)).assemble(basis)
    mass = skfem.BilinearForm(lambda u, v, w: 2700.0 * dot(u, v)).assemble(basis)
    bar = part(basis)
    ends = {"root": bar.nodes(lambda x: x[0] < 1e-9), "tip": bar.nodes(lambda x: x[0] > 1 - 1e-9)}
    return tisserand.reduce(stiffness, mass, interfaces=ends, modes=6, name="arm", **bar.arguments())


def test_a_mode_is_a_grid(arm, tmp_path):
    grid = mode(arm, 0)
    assert grid.n_points == len(arm.points) and grid.n_cells == 10
    # Bricks turned inside out would have negative volumes.
    assert grid.compute_cell_sizes()["Volume"].min() > 0
    largest = np.linalg.norm(grid.point_data["displacement"], axis=1).max()
    assert largest == pytest.approx(0.1 * np.sqrt(1 + 0.04**2 + 0.02**2), rel=0.2)


def test_a_mechanism_becomes_a_moving_picture(arm, tmp_path):
    arm.write(tmp_path / "arm.dcb.h5")
    scene = tisserand.Scene(3, gravity=[0, 0, -9.81])
    scene.body("arm", tmp_path / "arm.dcb.h5").revolute("axle", "ground", "arm/root", axis=[0, 1, 0])
    scene.output("tip", position={"at": "arm/tip"}).integrate(step=2e-3, end=0.2)
    scene.set(fields=[{"body": "arm", "every": 0.04, "directory": str(tmp_path / "pictures")}])
    results = tisserand.simulate(scene, tmp_path / "arm.h5")
    series = tmp_path / "pictures/arm.pvd"
    pictures = list(fields(series))
    assert [round(time, 9) for time, _ in pictures] == [0, 0.04, 0.08, 0.12, 0.16, 0.2]
    # The nodes of the tip are where the run says the tip is.
    at_tip = np.asarray(pictures[-1][1].points)[arm.points[:, 0] > 1 - 1e-9]
    assert np.allclose(at_tip.mean(axis=0), results["tip"][-1], atol=1e-6)
    target = tmp_path / "arm.gif"
    assert animate({"arm": series}, target) == 6
    assert target.stat().st_size > 10000
    with pytest.raises(tisserand.InputError, match="is no file"):
        list(fields(tmp_path / "nothing.pvd"))
