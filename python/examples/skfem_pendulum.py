"""From a solid of scikit-fem to the motion of a mechanism: two flexible arms, hinged to each other, fall under gravity."""

import sys

import numpy as np
import tisserand
from skfem import Basis, BilinearForm, ElementHex2, ElementVector, MeshHex
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity
from tisserand.skfem import part

# A bar of aluminium, 0.5 m x 20 mm x 10 mm, of quadratic bricks.
mesh = MeshHex.init_tensor(np.linspace(0, 0.5, 21), np.linspace(-0.01, 0.01, 3), np.linspace(-0.005, 0.005, 2))
basis = Basis(mesh, ElementVector(ElementHex2()))
stiffness = linear_elasticity(*lame_parameters(70e9, 0.33)).assemble(basis)
mass = BilinearForm(lambda u, v, w: 2700.0 * dot(u, v)).assemble(basis)

bar = part(basis)
ends = {"left": bar.nodes(lambda x: abs(x[0]) < 1e-9), "right": bar.nodes(lambda x: abs(x[0] - 0.5) < 1e-9)}
arm = tisserand.reduce(stiffness, mass, interfaces=ends, modes=8, damping=0.01, name="arm", **bar.arguments())
print(arm)

scene = tisserand.Scene(3, gravity=[0, 0, -9.81])
scene.body("upper", arm).body("lower", arm, position=[0.5, 0, 0])
scene.revolute("shoulder", "ground", "upper/left", axis=[0, 1, 0]).revolute("elbow", "upper/right", "lower/left", axis=[0, 1, 0])
scene.output("tip", position={"at": "lower/right"}).output("elbow", joint_coordinate={"joint": "elbow"}).output("energy", "energy")
scene.integrate(step=1e-3, end=1.0)
results = tisserand.simulate(scene)
print(results)

plot = results.plot("tip")
plot.figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "pendulum.png")
