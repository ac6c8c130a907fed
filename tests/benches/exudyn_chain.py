"""A chain of one superelement in Exudyn: the same matrices and the same basis as in the .dcb.h5 file.

    python3 exudyn_chain.py JOB.json RESULT.json

JOB holds `part` (PART.mtx), `superelement`, `bodies`, `step`, `steps`, `rho_infinity`, `newton` (see `NEWTON`), `gravity` and `record_every`.
Bodies hang on each other by revolute joints about z, the first on the ground, and are released at rest from a straight line. RESULT gets
times, counts and the positions of the last body's free end.

The basis is [Φ, G_res L_bᵀ T_r], so M is the identity, K = diag(ω², σ²) and C = diag(2ζω, 2ζσ) in both codes. `MarkerSuperElementRigid` with equal
weights takes the mean displacement of its nodes and the rotation (Σ p̃ᵀp̃)⁻¹ Σ p × u about their centroid, which is what an `average` interface is, and
both codes turn by the exponential of that vector. An offset of the interface from the centroid would be treated differently, so there must be none.
"""
import json
import resource
import sys
import time

sys.exudynFast = True  # the module without range checks
import exudyn as exu
import h5py
import numpy as np
from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface
from exudyn.utilities import MarkerBodyRigid, MarkerSuperElementRigid, ObjectGround, ObjectJointRevoluteZ, SensorMarker
from scipy.io import mmread
from scipy.spatial.transform import Rotation

# The contractivity above which modified Newton takes a new Jacobian: Exudyn's default, and what was fastest here. None: full Newton.
NEWTON = {"modified": 0.5, "eager": 0.03, "full": None}


def basis(superelement):
    """Columns (dofs, n): kept modes, then the orthonormal attachments; their eigenvalues; their damping ratios."""
    with h5py.File(superelement) as file:
        attachments = file["residual/shapes"][:].T @ file["residual/transform"][:]
        damping, rank = file["modes/damping"], attachments.shape[1]
        return (
            np.hstack([file["modes/shapes"][:].T, attachments]),
            np.concatenate([file["modes/eigenvalues"][:], file["residual/sigma2"][:]]),
            np.concatenate([damping[:], np.full(rank, damping.attrs["residual"])]),
        )


def interfaces(description):
    """Nodes and centroid of each interface."""
    points = np.array(description["points"])
    for interface in description["component"]["interfaces"]:
        nodes = np.array(interface["nodes"] if "nodes" in interface else description["point_sets"][interface["point_set"]])
        centre = points[nodes].mean(0)
        assert interface["kind"] == "average" and np.allclose(interface.get("position", centre), centre, rtol=0, atol=1e-12)
        yield nodes, centre


def reduced_body(job):
    stem = job["part"].removesuffix(".mtx")
    description = json.load(open(stem + ".json"))
    element = FEMinterface()
    element.nodes = {"Position": np.array(description["points"])}
    element.massMatrix, element.stiffnessMatrix = mmread(stem + ".mass.mtx").tocsr(), mmread(job["part"]).tocsr()
    element.elements, element.surface = [], []
    columns, eigenvalues, ratios = basis(job["superelement"])
    element.modeBasis = {"matrix": columns, "type": "NormalModes"}
    # Without the rounding of what should be zero the matrices are diagonal, which Exudyn makes use of.
    body = ObjectFFRFreducedOrderInterface(element, roundMassMatrix=1e-9, roundStiffnessMatrix=1e-9)
    damping = exu.MatrixContainer()
    damping.SetWithDenseMatrix(np.diag(2 * ratios * np.sqrt(eigenvalues)), useDenseMatrix=False)
    defects = dict(
        mass=float(np.abs(body.massMatrixReduced - np.eye(len(eigenvalues))).max()),
        stiffness=float(np.abs(body.stiffnessMatrixReduced - np.diag(eigenvalues)).max() / eigenvalues.max()),
    )
    return body, damping, list(interfaces(description)), defects


def assemble(job, body, damping, ends, bodies):
    """A chain; its tip sensor; the markers of the ground and of both ends of each body."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    (first_nodes, first_centre), (last_nodes, last_centre) = ends
    ground = system.AddObject(ObjectGround())
    markers = [system.AddMarker(MarkerBodyRigid(bodyNumber=ground, localPosition=first_centre.tolist()))]
    for index in range(bodies):
        added = body.AddObjectFFRFreducedOrder(
            system, positionRef=(index * (last_centre - first_centre)).tolist(), gravity=job["gravity"]
        )
        system.SetObjectParameter(added["oFFRFreducedOrder"], "dampingMatrixReduced", damping)
        ends_of_body = [
            system.AddMarker(
                MarkerSuperElementRigid(
                    bodyNumber=added["oFFRFreducedOrder"], meshNodeNumbers=nodes, weightingFactors=np.full(len(nodes), 1 / len(nodes))
                )
            )
            for nodes in (first_nodes, last_nodes)
        ]
        system.AddObject(ObjectJointRevoluteZ(markerNumbers=[markers[-1], ends_of_body[0]]))
        markers += ends_of_body
    tip = system.AddSensor(
        SensorMarker(markerNumber=markers[-1], outputVariableType=exu.OutputVariableType.Position, storeInternal=True, writeToFile=False)
    )
    system.Assemble()
    return container, system, tip, markers


def interface_rows(superelement):
    """L_b times the basis, (rows, n), as the file has it: six rows an interface."""
    with h5py.File(superelement) as file:
        residual = file["residual"]
        attachments = residual["output_shapes" if "output_shapes" in residual else "flexibility"][:] @ residual["transform"][:]
        return np.hstack([file["modes/interface_shapes"][:], attachments])


def kinematics_defect(system, markers, ends, rows):
    """Largest difference between Exudyn's interface frames and the file's, for a deformation that turns the first by 0.3 rad."""
    deformation = np.random.default_rng(1).standard_normal(rows.shape[1])
    deformation *= 0.3 / np.linalg.norm(rows[3:6] @ deformation)
    current = exu.ConfigurationType.Current
    system.systemData.SetODE2Coordinates(np.concatenate([np.zeros(7), deformation]), current)
    defects = []
    for marker, (_, centre), frame in zip(markers, ends, (rows[:6], rows[6:])):
        displacement = frame @ deformation
        position = system.GetMarkerOutput(marker, exu.OutputVariableType.Position, current)
        rotation = system.GetMarkerOutput(marker, exu.OutputVariableType.RotationMatrix, current)
        defects.append(np.abs(np.array(position) - centre - displacement[:3]).max())
        defects.append(np.abs(np.array(rotation).reshape(3, 3) - Rotation.from_rotvec(displacement[3:]).as_matrix()).max())
    return float(max(defects))


def settings(job):
    chosen = exu.SimulationSettings()
    time_integration = chosen.timeIntegration
    time_integration.numberOfSteps = job["steps"]
    time_integration.endTime = job["steps"] * job["step"]
    time_integration.adaptiveStep = False
    time_integration.verboseMode = 0
    time_integration.generalizedAlpha.spectralRadius = job["rho_infinity"]
    contractivity = NEWTON[job["newton"]]
    time_integration.newton.useModifiedNewton = contractivity is not None
    if contractivity is not None:
        time_integration.newton.modifiedNewtonContractivity = contractivity
    chosen.solution.file.write = False
    chosen.solution.sensors.writePeriod = job["record_every"] * job["step"]
    chosen.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    chosen.parallel.numberOfThreads = 1
    return chosen


def processor_time():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def main(job_path, result_path):
    job = json.load(open(job_path))
    body, damping, ends, defects = reduced_body(job)
    single_container, single, _, markers = assemble(job, body, damping, ends, 1)
    defects["kinematics"] = kinematics_defect(single, markers[1:], ends, interface_rows(job["superelement"]))
    container, system, tip, _ = assemble(job, body, damping, ends, job["bodies"])
    chosen = settings(job)
    newton = chosen.timeIntegration.newton
    solver = exu.MainSolverImplicitSecondOrder()
    started, used = time.perf_counter(), processor_time()
    solved = solver.SolveSystem(system, chosen)
    seconds, used = time.perf_counter() - started, processor_time() - used
    history = np.array(system.GetSensorStoredData(tip))
    json.dump(
        dict(
            solved=bool(solved),
            seconds=seconds,
            cpu_seconds=used,
            newton_iterations=solver.it.newtonStepsCount,
            jacobian_updates=solver.it.newtonJacobiCount,
            coordinates=body.nModes,
            unknowns=len(system.systemData.GetODE2Coordinates()) + len(system.systemData.GetAECoordinates()),
            interface_nodes=[len(nodes) for nodes, _ in ends],
            defects=defects,
            relative_tolerance=newton.relativeTolerance,
            linear_solver="EigenSparse",
            version=exu.config.Version(),
            time=history[:, 0].tolist(),
            position=history[:, 1:4].tolist(),
        ),
        open(result_path, "w"),
    )


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
