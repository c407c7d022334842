"""Writes mesh files beside it from box.msh22.ascii.msh and from a box in mm: by meshio 5.3.5, Gmsh 4.15.2
and VTK 9.7.2."""
import os, sys
import gmsh, meshio, numpy as np, vtk

HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = os.path.join(HERE, "box.msh22.ascii.msh")


def path(name):
    return os.path.join(HERE, name)


def by_meshio():
    box = meshio.read(SOURCE)
    group = box.cell_data["gmsh:physical"]
    plain = dict(cells=box.cells, cell_data={"gmsh:physical": group})
    mesh = meshio.Mesh(box.points, **plain)
    meshio.vtu.write(path("box.meshio.ascii.vtu"), mesh, binary=False)
    meshio.vtu.write(path("box.meshio.zlib.vtu"), mesh)
    meshio.write(path("box.meshio.avs"), mesh)
    sets = {"body": np.arange(len(box.points)), "held below": np.unique(box.cells[0].data[group[0] == 7])}
    meshio.write(path("box.meshio.inp"), meshio.Mesh(box.points, box.cells, point_sets=sets))
    meshio.write(path("box.meshio.mesh"), meshio.Mesh(box.points, box.cells, cell_data={"medit:ref": group}))
    tetra = [block for block in box.cells if block.type == "tetra"]
    region = {"tetgen:ref": [group[1]]}
    meshio.write(path("box.meshio.node"), meshio.Mesh(box.points, tetra, cell_data=region))


def by_gmsh():
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(path("box.msh41.ascii.msh"))
    gmsh.write(path("box.gmsh.inp"))
    # Gmsh writes .mesh of a geometry of its own alone.
    gmsh.clear()
    gmsh.model.occ.addBox(0, 0, 0, 20, 20, 10)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [1], 1, "body")
    gmsh.model.addPhysicalGroup(2, [5], 7, "below")
    gmsh.option.setNumber("Mesh.MeshSizeMin", 10)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 10)
    gmsh.model.mesh.generate(3)
    for ending in ["mesh", "inp"]:
        gmsh.write(path(f"mm.gmsh.{ending}"))
    # The whole surface, whatever has a group.
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    for ending in ["stl", "obj"]:
        gmsh.write(path(f"mm.gmsh.{ending}"))
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.write(path("mm.gmsh.binary.stl"))
    gmsh.finalize()


def by_meshio_of_surface():
    surface = meshio.read(path("mm.gmsh.obj"))
    surface.point_data = {}
    meshio.ply.write(path("mm.meshio.ascii.ply"), surface, binary=False)
    meshio.ply.write(path("mm.meshio.binary.ply"), surface)


def by_vtk():
    reader = vtk.vtkUnstructuredGridReader()
    reader.SetFileName(path("box.ascii.vtk"))
    reader.ReadAllScalarsOn()
    reader.Update()
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(reader.GetOutput())
    # Mode 1 is base64 in the text, 2 is appended data.
    for name, mode, encode, zlib, wide, little in [
        ("raw", 2, 0, 0, 1, 1),
        ("raw_zlib", 2, 0, 1, 0, 1),
        ("base64_zlib", 2, 1, 1, 1, 1),
        ("inline", 1, 0, 0, 0, 1),
        ("big", 2, 0, 0, 0, 0),
    ]:
        writer.SetFileName(path(f"box.vtk.{name}.vtu"))
        writer.SetDataMode(mode)
        writer.SetEncodeAppendedData(encode)
        (writer.SetCompressorTypeToZLib if zlib else writer.SetCompressorTypeToNone)()
        (writer.SetHeaderTypeToUInt64 if wide else writer.SetHeaderTypeToUInt32)()
        (writer.SetByteOrderToLittleEndian if little else writer.SetByteOrderToBigEndian)()
        writer.Write()


by_meshio()
by_gmsh()
by_meshio_of_surface()
by_vtk()
