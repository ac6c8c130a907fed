"""The cells of gmsh_cells.py as VTK writes them, in every encoding: python vtu_cells.py (vtk 9, gmsh 4.15.2) writes ../mesh/cells/*.vtu."""
import os
import gmsh
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "mesh", "cells")
# Gmsh's type: VTK's, and the places of its nodes in Gmsh's order.
KINDS = {15: (1, [0]), 8: (21, [0, 1, 2]), 9: (22, range(6)), 16: (23, range(8)), 11: (24, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
         17: (25, [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]),
         18: (26, [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11]), 19: (27, [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12])}
gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)
gmsh.open(os.path.join(HERE, "edges_41.msh"))
tags, coordinates, _ = gmsh.model.mesh.getNodes()
xyz = np.array(coordinates).reshape(-1, 3)
place = {int(tag): k for k, tag in enumerate(tags)}
grid = vtk.vtkUnstructuredGrid()
points = vtk.vtkPoints()
points.SetDataTypeToDouble()
for point in xyz:
    points.InsertNextPoint(point)
grid.SetPoints(points)
for kind, labels, nodes in zip(*gmsh.model.mesh.getElements()):
    for cell in np.reshape(nodes, (len(labels), -1)):
        number, order = KINDS[kind]
        grid.InsertNextCell(number, len(cell), [place[int(cell[k])] for k in order])
gmsh.finalize()
# A wedge, a pixel and a voxel in VTK's own order, on points that are there.
at = lambda *p: int(np.flatnonzero(np.all(np.isclose(xyz, p), axis=1))[0])
wedge = [at(2, 0, 0), at(2, 1, 0), at(4, 0, 0), at(2, 0, 3), at(2, 1, 3), at(4, 0, 3)]
grid.InsertNextCell(vtk.VTK_WEDGE, 6, wedge)
bottom = [at(0, 0, 0), at(2, 0, 0), at(0, 1, 0), at(2, 1, 0)]
grid.InsertNextCell(vtk.VTK_PIXEL, 4, bottom)
grid.InsertNextCell(vtk.VTK_VOXEL, 8, bottom + [at(0, 0, 3), at(2, 0, 3), at(0, 1, 3), at(2, 1, 3)])
grid.InsertNextCell(vtk.VTK_POLY_LINE, 3, bottom[:3])
ids = numpy_to_vtk((7 * np.arange(len(xyz)) % 97 + 11).astype(np.int32), deep=1)
ids.SetName("Node_ID")
grid.GetPointData().AddArray(ids)
field = numpy_to_vtk(np.linspace(0, 1, 3 * len(xyz)).reshape(-1, 3), deep=1)
field.SetName("displacement & more")
grid.GetPointData().AddArray(field)
for name, mode, compressor, header, order, encode in (
    ("ascii", "Ascii", None, 32, "Little", 1), ("inline", "Binary", None, 32, "Little", 1), ("inline_zlib", "Binary", "ZLib", 64, "Big", 1),
    ("appended_raw", "Appended", None, 64, "Little", 0), ("appended_raw_zlib", "Appended", "ZLib", 32, "Big", 0),
    ("appended_base64", "Appended", None, 64, "Big", 1), ("appended_base64_zlib", "Appended", "ZLib", 64, "Little", 1), ("lz4", "Appended", "LZ4", 32, "Little", 1),
):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(os.path.join(HERE, f"edges_{name}.vtu"))
    writer.SetInputData(grid)
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{compressor or 'None'}")()
    # Blocks of 256 bytes: several of each array.
    writer.SetBlockSize(256)
    getattr(writer, f"SetHeaderTypeToUInt{header}")()
    getattr(writer, f"SetByteOrderTo{order}Endian")()
    writer.SetEncodeAppendedData(encode)
    assert writer.Write()
