"""Other people's simplifiers, one call per process, so that a crash or a leak of one is seen as its own.

    rivals.py clean SOURCE OUT.ply            the mesh that everybody gets: binary PLY, welded, without degenerate,
                                              duplicate or unreferenced elements; says its counts
    rivals.py simplify NAME IN.ply OUT.ply N  IN with about N triangles; says the seconds of the call alone
    rivals.py distance A.ply B.ply SAMPLES    a second yardstick: MeshLab's sampled distance from A to B

Each prints one line of JSON.
"""

import gzip
import json
import os
import shutil
import sys
import tempfile
import time

import numpy as np


def read(path):
    """Positions, float32 [n, 3], and triangles, int64 [m, 3], of any file that MeshLab reads, or its .gz."""
    import pymeshlab

    with tempfile.TemporaryDirectory() as folder:
        if path.endswith(".gz"):
            plain = os.path.join(folder, os.path.basename(path)[:-3])
            with gzip.open(path, "rb") as packed, open(plain, "wb") as out:
                shutil.copyfileobj(packed, out)
            path = plain
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(path)
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix().astype(np.float32), mesh.face_matrix().astype(np.int64)


def write(path, positions, triangles):
    """Binary little-endian PLY: x, y, z as float, indices as int after a count of one byte."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(positions)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = triangles
    with open(path, "wb") as out:
        out.write(header.encode())
        out.write(positions.astype("<f4").tobytes())
        out.write(faces.tobytes())


def clean(source, out):
    positions, triangles = read(source)
    positions = positions + np.float32(0)  # -0 and 0 are one place
    positions, same = np.unique(positions, axis=0, return_inverse=True)
    triangles = same.reshape(-1)[triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    triangles = triangles[np.sort(first)]
    used, triangles = np.unique(triangles, return_inverse=True)
    positions, triangles = positions[used], triangles.reshape(-1, 3)
    write(out, positions, triangles)
    return {"vertices": len(positions), "triangles": len(triangles)}


def vtk_quadric(positions, triangles, count):
    """vtkQuadricDecimation as pyvista's `decimate` calls it: no volume preservation, no attributes."""
    import vtk
    from vtk.util import numpy_support

    points = vtk.vtkPoints()
    points.SetData(numpy_support.numpy_to_vtk(positions, deep=True))
    cells = vtk.vtkCellArray()
    flat = np.hstack([np.full((len(triangles), 1), 3), triangles]).astype(np.int64)
    cells.ImportLegacyFormat(numpy_support.numpy_to_vtkIdTypeArray(flat.ravel(), deep=True))
    surface = vtk.vtkPolyData()
    surface.SetPoints(points)
    surface.SetPolys(cells)
    decimate = vtk.vtkQuadricDecimation()
    decimate.SetInputData(surface)
    decimate.SetTargetReduction(1 - count / len(triangles))
    start = time.perf_counter()
    decimate.Update()
    seconds = time.perf_counter() - start
    result = decimate.GetOutput()
    corners = numpy_support.vtk_to_numpy(result.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return numpy_support.vtk_to_numpy(result.GetPoints().GetData()), corners, seconds


def fast_simplification(positions, triangles, count):
    import fast_simplification

    triangles = triangles.astype(np.int32)
    start = time.perf_counter()
    points, faces = fast_simplification.simplify(positions, triangles, target_count=count)
    return points, faces, time.perf_counter() - start


def pymeshlab(positions, triangles, count):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(positions.astype(np.float64), triangles.astype(np.int32)))
    start = time.perf_counter()
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=count)
    seconds = time.perf_counter() - start
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix(), seconds


RIVALS = {"vtk": vtk_quadric, "fast-simplification": fast_simplification, "pymeshlab": pymeshlab}


def simplify(name, source, out, count):
    points, faces, seconds = RIVALS[name](*read(source), int(count))
    write(out, np.asarray(points), np.asarray(faces))
    return {"triangles": len(faces), "seconds": seconds}


def distance(a, b, samples):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(a)
    meshes.load_new_mesh(b)
    found = meshes.get_hausdorff_distance(
        sampledmesh=0, targetmesh=1, samplevert=True, sampleedge=False, sampleface=True, samplenum=int(samples),
        maxdist=pymeshlab.PercentageValue(50),
    )
    return {"max": found["max"], "mean": found["mean"], "rms": found["RMS"], "samples": found["n_samples"]}


if __name__ == "__main__":
    commands = {"clean": clean, "simplify": simplify, "distance": distance}
    if len(sys.argv) < 2 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    print(json.dumps(commands[sys.argv[1]](*sys.argv[2:])))
