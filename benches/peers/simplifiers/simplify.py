"""Simplifies a mesh with fast-simplification, VTK or PyMeshLab: METHOD MESH.ply FACES RUNS OUT.ply. Prints what it
cost, as all programs here do. `subdivide MESH.ply OUT.ply`: Loop subdivision by PyMeshLab."""

import statistics
import sys
import time


class FastSimplification:
    def __init__(self, path, faces, aggressiveness):
        import fast_simplification
        import pymeshlab

        self.module = fast_simplification
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(path)
        self.points = meshes.current_mesh().vertex_matrix().astype("float32")
        self.triangles = meshes.current_mesh().face_matrix()
        self.options = {"target_count": faces, "agg": aggressiveness}

    def prepare(self):
        self.result = None

    def simplify(self):
        self.result = self.module.simplify(self.points, self.triangles, **self.options)

    def write(self, path):
        import pymeshlab

        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(*self.result))
        meshes.save_current_mesh(path)


class Vtk:
    def __init__(self, path, faces):
        import vtk

        self.vtk = vtk
        reader = vtk.vtkPLYReader()
        reader.SetFileName(path)
        reader.Update()
        self.mesh = reader.GetOutput()
        self.reduction = 1 - faces / self.mesh.GetNumberOfPolys()

    def prepare(self):
        self.filter = self.vtk.vtkQuadricDecimation()
        self.filter.SetInputData(self.mesh)
        self.filter.SetTargetReduction(self.reduction)

    def simplify(self):
        self.filter.Update()

    def write(self, path):
        writer = self.vtk.vtkPLYWriter()
        writer.SetFileName(path)
        writer.SetInputData(self.filter.GetOutput())
        writer.Write()


class PyMeshLab:
    def __init__(self, path, faces):
        import pymeshlab

        self.meshes = pymeshlab.MeshSet()
        self.path, self.faces = path, faces

    def prepare(self):
        self.meshes.clear()
        self.meshes.load_new_mesh(self.path)

    def simplify(self):
        self.meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=self.faces)

    def write(self, path):
        self.meshes.save_current_mesh(path)


METHODS = {
    "fast-simplification-3": lambda path, faces: FastSimplification(path, faces, 3),
    # Its default.
    "fast-simplification-7": lambda path, faces: FastSimplification(path, faces, 7),
    "vtk": Vtk,
    "pymeshlab": PyMeshLab,
}


def resident_mb(field):
    with open("/proc/self/status") as status:
        kib = next(line.split()[1] for line in status if line.startswith(field))
    return int(kib) * 1024 / 1e6


def cost(method):
    """Seconds on the clock and of the processor, megabytes resident before and at most above that."""
    with open("/proc/self/clear_refs", "w") as peak:
        peak.write("5")
    before_mb = resident_mb("VmRSS:")
    started, cpu = time.perf_counter(), time.process_time()
    method.simplify()
    cpu_s, wall_s = time.process_time() - cpu, time.perf_counter() - started
    return wall_s, cpu_s, before_mb, resident_mb("VmHWM:") - before_mb


def simplify(name, path, faces, runs, out):
    method = METHODS[name](path, int(faces))
    costs = []
    for _ in range(int(runs)):
        method.prepare()
        costs.append(cost(method))
    method.write(out)
    wall_s, cpu_s = (statistics.median(cost[k] for cost in costs) for k in (0, 1))
    print(f"{wall_s:.4f},{cpu_s:.4f},{costs[0][2]:.1f},{costs[0][3]:.1f}")


def subdivide(path, out):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(path)
    threshold = pymeshlab.PercentageValue(0)
    meshes.meshing_surface_subdivision_loop(iterations=1, threshold=threshold)
    meshes.save_current_mesh(out)


if sys.argv[1] == "subdivide":
    subdivide(*sys.argv[2:])
else:
    simplify(*sys.argv[1:])
