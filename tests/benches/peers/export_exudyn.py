"""Exudyn loads what `reduce export --to exudyn` wrote: its arrays against Exudyn's own integrals over K and M, then a pendulum against a recorded history.

    python3 export_exudyn.py PART.dcb.h5 PART.hdf5 [--matrices PART.mtx PART.mass.mtx] [--pendulum RECORD.json]      exudyn numpy scipy h5py

--matrices: the finite elements' stiffness and mass, nodes in the order of the mesh with x, y, z each. The pendulum hangs by the first interface
and reports the last one, as RECORD.json says; each is the mean of a node set, or a frame of four nodes in a file without nodal fields. Exit status 1 where a limit is broken.
"""
import argparse
import json
import warnings

import exudyn as exu
import h5py
import numpy as np
import scipy.io
import scipy.sparse
from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface
from exudyn.utilities import (
    MarkerBodyPosition,
    MarkerSuperElementPosition,
    MarkerSuperElementRigid,
    ObjectGround,
    ObjectJointSpherical,
    SensorMarker,
)

warnings.filterwarnings("ignore", category=DeprecationWarning)                   # names of settings, which older versions know alone
INTEGRALS, PENDULUM = 1e-12, 1e-8
ORTHONORMALITY = 1e-9                                                            # ΦᵀMΦ = 1 and ΦᵀKΦ = diag(ω²): as good as the modes were found
ARRAYS = ["massMatrixReduced", "stiffnessMatrixReduced", "inertiaLocal", "Mtt", "totalMass", "chiU", "chiUtilde", "mPsiTildePsi", "mPsiTildePsiTilde"]
ARRAYS += ["mPhitTPsi", "mPhitTPsiTilde", "mXRefTildePsi", "mXRefTildePsiTilde", "xRef"]


def loaded(path):
    part = ObjectFFRFreducedOrderInterface()
    part.LoadFromFile(path)
    return part


def own_integrals(part, stiffness, mass):
    """Exudyn's integration over the whole matrices, for the nodes and shapes that it loaded."""
    fem = FEMinterface()
    fem.nodes = {"Position": part.xRef.reshape(-1, 3)}
    fem.massMatrix, fem.stiffnessMatrix = (scipy.sparse.csr_matrix(scipy.io.mmread(path)) for path in (mass, stiffness))
    fem.modeBasis = {"matrix": part.modeBasis, "type": "NormalModes"}
    triangles = np.array(part.trigList)
    fem.surface = [{"Name": "skin", "Trigs": triangles}]
    return ObjectFFRFreducedOrderInterface(fem, roundMassMatrix=0, roundStiffnessMatrix=0)


def scale_of(name, part, own):
    """What an entry is measured by. Integrals that vanish on mean axes: by mass (or moment) times the largest displacement."""
    size = np.abs(part.modeBasis).max()
    arm = np.abs(part.xRef).max()
    vanishing = {
        "chiU": arm, "chiUtilde": arm, "mPhitTPsi": part.totalMass * size, "mPhitTPsiTilde": part.totalMass * size, "mXRefTildePsi": part.totalMass * size * arm,
    }
    return vanishing.get(name) or np.abs(getattr(own, name)).max()


def compare(part, stiffness, mass):
    own = own_integrals(part, stiffness, mass)
    worst = {}
    for name in ARRAYS:
        a, b = np.asarray(getattr(part, name), float), np.asarray(getattr(own, name), float)
        assert a.shape == b.shape, (name, a.shape, b.shape)
        worst[name] = float(np.abs(a - b).max() / scale_of(name, part, own))
    return worst


def node_sets(superelement, count):
    """Nodes of the first and the last interface: the sets whose mean position is the interface's, or each frame's four."""
    with h5py.File(superelement) as file:
        if count == 4 * len(file["interfaces/names"]):
            return list(range(4)), list(range(count - 4, count))
        at = file["interfaces/positions"][:] + file["frame/origin"][:]
        points = file["mesh/points"][:]
        sets = [group[:] for group in file["mesh/point_sets"].values()]
    near = lambda place: min(sets, key=lambda nodes: np.linalg.norm(points[nodes].mean(axis=0) - place))
    return near(at[0]).tolist(), near(at[-1]).tolist()


def run(part, held, seen, record, step):
    given = record["parameters"]
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    pin, spin = np.array(given["pin"]), np.array(given["angular_velocity"])
    added = part.AddObjectFFRFreducedOrder(
        mbs, positionRef=[0, 0, 0], initialVelocity=list(np.cross(spin, -pin)), rotationMatrixRef=np.eye(3), initialAngularVelocity=list(spin), gravity=given["gravity"]
    )
    body = added["oFFRFreducedOrder"]

    def mean(nodes):
        """Of a mesh the mean displacement, of a frame's four nodes displacement and rotation."""
        kind = MarkerSuperElementRigid if len(nodes) == 4 else MarkerSuperElementPosition
        return mbs.AddMarker(kind(bodyNumber=body, meshNodeNumbers=nodes, weightingFactors=[1 / len(nodes)] * len(nodes)))

    ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.AddObject(ObjectGround()), localPosition=list(pin)))
    mbs.AddObject(ObjectJointSpherical(markerNumbers=[ground, mean(held)]))
    sensor = mbs.AddSensor(SensorMarker(markerNumber=mean(seen), outputVariableType=exu.OutputVariableType.Position, storeInternal=True, writeToFile=False))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(given["end"] / step)
    settings.timeIntegration.endTime = given["end"]
    settings.timeIntegration.newton.useModifiedNewton = False
    settings.timeIntegration.newton.relativeTolerance = 1e-10
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = given["sampled_every"]
    settings.solutionSettings.sensorsStoreAndWriteFiles = True
    mbs.SolveDynamic(settings)
    return mbs.GetSensorStoredData(sensor)[:, 1:4]


def pendulum(path, superelement, record):
    held, seen = node_sets(superelement, loaded(path).nNodes)
    coarse, fine = (run(loaded(path), held, seen, record, step) for step in record["parameters"]["steps"])
    found = fine + (fine - coarse) / 3                                            # Richardson: both are of second order
    recorded = np.array(record["exudyn"])
    assert found.shape == recorded.shape, (found.shape, recorded.shape)
    return float(np.abs(found - recorded).max()), [float(v) for v in np.ptp(recorded, axis=0)]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("superelement")
    arguments.add_argument("exported")
    arguments.add_argument("--matrices", nargs=2)
    arguments.add_argument("--pendulum")
    given = arguments.parse_args()
    part = loaded(given.exported)
    print(f"Exudyn {exu.config.Version()} loads {given.exported}: {part.nNodes} nodes, {part.nModes} modes, {len(part.trigList)} triangles")
    broken = False
    if given.matrices:
        worst = compare(part, *given.matrices)
        for name, off in worst.items():
            print(f"  {name:<20} {off:.1e}")
        modes = max(worst.pop("massMatrixReduced"), worst.pop("stiffnessMatrixReduced"))
        broken |= not (max(worst.values()) <= INTEGRALS and modes <= ORTHONORMALITY)
        print(f"arrays against Exudyn's integration over K and M: {max(worst.values()):.1e} (allowed {INTEGRALS:.0e}); M and K themselves {modes:.1e} (allowed {ORTHONORMALITY:.0e})")
    if given.pendulum:
        with open(given.pendulum) as file:
            off, travel = pendulum(given.exported, given.superelement, json.load(file))
        broken |= not off <= PENDULUM
        print(f"pendulum against the recorded history: {off:.1e} m over a travel of {max(travel):.3f} m (allowed {PENDULUM:.0e} m)")
    raise SystemExit(int(broken))


if __name__ == "__main__":
    main()
