"""A mechanism with one reduced body in Exudyn: the same matrices and the same basis as in the .dcb.h5 file.

    python3 exudyn_mechanism.py JOB.json RESULT.json

JOB holds `kind` (`slider-crank` or `free`), `part`, `superelement`, `node`, `step`, `steps`, `rho_infinity`, `newton`, `record_every`, and what
`speed_against_error.py` says of the mechanism. RESULT gets times, counts, the positions of the node and of both interfaces, and the node's elastic
displacement in body axes (`local`).

`slider-crank`: a rigid crank turns freely about z with a flywheel's inertia; the body's first interface is hinged to it, the second holds a
rigid slider by a spherical joint, which slides along x. `free`: nothing holds the body. See `exudyn_chain.py` for the basis and the interfaces.
"""
import json
import sys
import time

import exudyn_chain as chain
import exudyn as exu
import numpy as np
from exudyn.utilities import (
    GenericJoint,
    InertiaSphere,
    MarkerBodyRigid,
    MarkerSuperElementRigid,
    ObjectGround,
    ObjectJointRevoluteZ,
    RigidBodyInertia,
    SensorMarker,
    SensorSuperElement,
)

POSITION = exu.OutputVariableType.Position


def interface_marker(system, added, nodes):
    return system.AddMarker(
        MarkerSuperElementRigid(
            bodyNumber=added["oFFRFreducedOrder"], meshNodeNumbers=nodes, weightingFactors=np.full(len(nodes), 1 / len(nodes))
        )
    )


def body_of(job, system, body, damping):
    added = body.AddObjectFFRFreducedOrder(
        system,
        positionRef=job["position"],
        initialVelocity=job["velocity"],
        initialAngularVelocity=job["angular_velocity"],
        gravity=[0, 0, 0],
    )
    system.SetObjectParameter(added["oFFRFreducedOrder"], "dampingMatrixReduced", damping)
    return added


def slider_crank(job, system, ends):
    """Crank, slider and joints about the body's markers."""
    radius, speed = job["crank"], job["speed"]
    ground = system.AddObject(ObjectGround())
    moment = job["flywheel"]
    crank = system.CreateRigidBody(
        inertia=RigidBodyInertia(mass=1.0, inertiaTensor=np.eye(3) * moment),
        referencePosition=[0, 0, 0],
        initialAngularVelocity=[0, 0, speed],
        gravity=[0, 0, 0],
        returnDict=True,
    )["bodyNumber"]
    slider = system.CreateRigidBody(
        inertia=InertiaSphere(mass=job["slider"], radius=0.01),
        referencePosition=job["slider_position"],
        gravity=[0, 0, 0],
        returnDict=True,
    )["bodyNumber"]

    def on(body, place):
        return system.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=place))

    system.AddObject(ObjectJointRevoluteZ(markerNumbers=[on(ground, [0, 0, 0]), on(crank, [0, 0, 0])]))
    system.AddObject(ObjectJointRevoluteZ(markerNumbers=[on(crank, [radius, 0, 0]), ends[0]]))
    free_turns = [1, 1, 1, 0, 0, 0]
    system.AddObject(GenericJoint(markerNumbers=[on(slider, [0, 0, 0]), ends[1]], constrainedAxes=free_turns))
    along_x = [0, 1, 1, 1, 1, 1]
    guide = on(ground, job["slider_position"])
    system.AddObject(GenericJoint(markerNumbers=[guide, on(slider, [0, 0, 0])], constrainedAxes=along_x))


def main(job_path, result_path):
    with open(job_path) as file:
        job = json.load(file)
    body, damping, ends, defects = chain.reduced_body(job)
    container = exu.SystemContainer()
    system = container.AddSystem()
    added = body_of(job, system, body, damping)
    markers = [interface_marker(system, added, nodes) for nodes, _ in ends]
    if job["kind"] == "slider-crank":
        slider_crank(job, system, markers)

    def kept(sensor):
        return system.AddSensor(sensor)

    sensors = {
        "node": kept(
            SensorSuperElement(
                bodyNumber=added["oFFRFreducedOrder"], meshNodeNumber=job["node"], storeInternal=True, writeToFile=False,
                outputVariableType=POSITION,
            )
        )
    }
    for name, marker in zip("ab", markers):
        sensors[name] = kept(SensorMarker(markerNumber=marker, outputVariableType=POSITION, storeInternal=True, writeToFile=False))
    local = exu.OutputVariableType.DisplacementLocal
    sensors["local"] = kept(
        SensorSuperElement(
            bodyNumber=added["oFFRFreducedOrder"], meshNodeNumber=job["node"], storeInternal=True, writeToFile=False, outputVariableType=local
        )
    )
    system.Assemble()
    chosen = chain.settings(job)
    solver = exu.MainSolverImplicitSecondOrder()
    started, used = time.perf_counter(), chain.processor_time()
    solved = solver.SolveSystem(system, chosen)
    seconds, used = time.perf_counter() - started, chain.processor_time() - used
    histories = {name: np.array(system.GetSensorStoredData(sensor)) for name, sensor in sensors.items()}
    result = dict(
        solved=bool(solved),
        seconds=seconds,
        cpu_seconds=used,
        newton_iterations=solver.it.newtonStepsCount,
        jacobian_updates=solver.it.newtonJacobiCount,
        coordinates=body.nModes,
        unknowns=len(system.systemData.GetODE2Coordinates()) + len(system.systemData.GetAECoordinates()),
        defects=defects,
        version=exu.config.Version(),
        time=histories["node"][:, 0].tolist(),
        **{name: history[:, 1:4].tolist() for name, history in histories.items()},
    )
    with open(result_path, "w") as file:
        json.dump(result, file)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
