"""One cell of every kind in every form of .msh, .unv and .vtu: python gmsh_cells.py (gmsh 4.15.2, meshio 5.3.5) writes ../mesh/cells/*.

A cube, a pyramid on it, a wedge and a tetrahedron beside it, faces, edges and points of them; linear, with middles of edges, with all middles.
Edges are straight: middles tell the order of the nodes. Surface 1 is in two groups; group 7 of curves has no name; "both ends" is of points and curves.
Further ones by hand: big-endian, and sizes of 4 bytes.
"""
import os, struct, sys
import gmsh, meshio, numpy as np

OUT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "mesh", "cells")
os.makedirs(OUT, exist_ok=True)
POINTS = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 3], [2, 0, 3], [2, 1, 3], [0, 1, 3], [1, 0.4, 5],
                   [4, 0, 0], [4, 0, 3], [5, 2, 1]], float)
LABELS = [70 * k % 83 + 5 for k in range(1, 13)]
VOLUMES = {5: [0, 1, 2, 3, 4, 5, 6, 7], 7: [4, 5, 6, 7, 8], 6: [1, 9, 2, 5, 10, 6], 4: [9, 11, 2, 10]}
FACES = {3: [0, 3, 7, 4], 2: [9, 2, 11]}


def label(nodes):
    return [LABELS[n] for n in nodes]


def build(order, incomplete):
    gmsh.clear()
    gmsh.model.add("cells")
    for dim, tag in ((3, 1), (2, 1), (2, 2), (1, 1), (0, 1)):
        gmsh.model.addDiscreteEntity(dim, tag)
    gmsh.model.mesh.addNodes(3, 1, LABELS, POINTS.ravel().tolist())
    for kind, nodes in VOLUMES.items():
        gmsh.model.mesh.addElementsByType(1, kind, [], label(nodes))
    for tag, (kind, nodes) in enumerate(FACES.items(), 1):
        gmsh.model.mesh.addElementsByType(tag, kind, [], label(nodes))
    gmsh.model.mesh.addElementsByType(1, 1, [], label([8, 4]))
    gmsh.model.mesh.addElementsByType(1, 15, [], label([11]))
    for dim, entities, number, name in ((3, [1], 1, "the part"), (2, [1], 2, "left"), (2, [1, 2], 3, "both faces"), (1, [1], 7, ""),
                                        (1, [1], 8, "both ends"), (0, [1], 4, "both ends")):
        gmsh.model.addPhysicalGroup(dim, entities, number, name)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", incomplete)
    gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
    if order > 1:
        gmsh.model.mesh.setOrder(order)


def write(name, version, binary, **options):
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    for key, value in options.items():
        gmsh.option.setNumber("Mesh." + key, value)
    gmsh.write(os.path.join(OUT, name))
    for key in options:
        gmsh.option.setNumber("Mesh." + key, 0)


def by_hand(name, order, size):
    """Version 4.1 of what Gmsh holds, with another byte order and width of sizes."""
    z = lambda *v: struct.pack(order + {4: "I", 8: "Q"}[size] * len(v), *map(int, v))
    i = lambda *v: struct.pack(order + "i" * len(v), *map(int, v))
    d = lambda v: struct.pack(order + "d" * len(v), *v)
    groups = [(dim, tag, gmsh.model.getPhysicalName(dim, tag)) for dim, tag in gmsh.model.getPhysicalGroups()]
    named = [g for g in groups if g[2]]
    entities = b""
    for dim in range(4):
        for _, tag in gmsh.model.getEntities(dim):
            mine = gmsh.model.getPhysicalGroupsForEntity(dim, tag)
            entities += i(tag) + d([0.0] * (3 if dim == 0 else 6)) + z(len(mine)) + i(*[-m for m in mine]) + (z(0) if dim else b"")
    counts = [len(gmsh.model.getEntities(dim)) for dim in range(4)]
    tags, points, _ = gmsh.model.mesh.getNodes()
    nodes = z(1, len(tags), min(tags), max(tags)) + i(3, 1, 0) + z(len(tags)) + z(*tags) + d(points)
    blocks, total = [], 0
    for dim, tag in gmsh.model.getEntities():
        for kind, labels, members in zip(*gmsh.model.mesh.getElements(dim, tag)):
            per = len(members) // len(labels)
            body = b"".join(z(l, *members[k * per:(k + 1) * per]) for k, l in enumerate(labels))
            blocks.append(i(dim, tag, kind) + z(len(labels)) + body)
            total += len(labels)
    elements = z(len(blocks), total, 1, total) + b"".join(blocks)
    with open(os.path.join(OUT, name), "wb") as f:
        f.write(b"$MeshFormat\n4.1 1 %d\n" % size + i(1) + b"\n$EndMeshFormat\n$PhysicalNames\n%d\n" % len(named))
        f.write("".join('%d %d "%s"\n' % g for g in named).encode() + b"$EndPhysicalNames\n$Entities\n" + z(*counts) + entities)
        f.write(b"\n$EndEntities\n$Comments\nnothing\n$EndComments\n$Nodes\n" + nodes + b"\n$EndNodes\n$Elements\n" + elements + b"\n$EndElements\n")


gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)
for name, order, incomplete in (("linear", 1, 0), ("edges", 2, 1), ("full", 2, 0)):
    build(order, incomplete)
    write(f"{name}_41.msh", 4.1, 0)
    write(f"{name}_41_binary.msh", 4.1, 1)
    write(f"{name}_22.msh", 2.2, 0)
    write(f"{name}_22_binary.msh", 2.2, 1)
    if name != "full":
        by_hand(f"{name}_41_big.msh", ">", 8)
        write(f"{name}.unv", 2.2, 0, SaveGroupsOfNodes=0)
    if name == "edges":
        by_hand("edges_41_size4.msh", "<", 4)
        write("edges_40.msh", 4.0, 0)
        write("edges_1.msh", 1.0, 0)

# A curved part of tetrahedra, with parameters of its nodes, and in two partitions.
gmsh.clear()
gmsh.model.add("curved")
gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 1, 1)
gmsh.model.occ.synchronize()
gmsh.option.setNumber("Mesh.MeshSizeMin", 1.2)
gmsh.option.setNumber("Mesh.MeshSizeMax", 1.2)
gmsh.option.setNumber("Mesh.SecondOrderLinear", 0)
gmsh.model.mesh.generate(3)
gmsh.model.addPhysicalGroup(3, [1], 1, "part")
gmsh.model.addPhysicalGroup(2, [1], 2, "mantle")
for version in (2.2, 4.1):
    for binary in (0, 1):
        write("curved_%d%s.msh" % (10 * version, "_binary" * binary), version, binary)
        write("curved_%d%s_parameters.msh" % (10 * version, "_binary" * binary), version, binary, SaveParametric=1)
gmsh.option.setNumber("Mesh.PartitionCreateTopology", 1)
gmsh.model.mesh.partition(2)
for binary in (0, 1):
    write("curved_41%s_partitioned.msh" % ("_binary" * binary), 4.1, binary)
gmsh.finalize()
