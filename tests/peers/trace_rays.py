"""Traces rays with embreex (Embree 4) for tests/peers/embreex.rs.

The argument is `robust` or `fast`. All numbers are little-endian, floats and integers of 32 bits.
First the input holds the number of meshes and for each the numbers of its vertices and triangles, three
floats for each vertex and three indices for each triangle; the answer is a line with versions. Then
each batch of rays is a kind of query (0: closest hit, 1: occlusion), a number of rays, and seven
floats for each ray: origin, direction, t_max. The answer to the first kind is five numbers for each
ray: the integers geomID and primID (-1: no hit) and the floats t, u, v; to the second one integer, which
is -1 where the segment is free.
"""

import sys
from importlib.metadata import version

import numpy
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore import EmbreeDevice
from embreex.rtcore_scene import EmbreeScene


def read(kind, *shape):
    count = 4
    for length in shape:
        count *= int(length)
    data = sys.stdin.buffer.read(count)
    if len(data) < count:
        sys.exit()
    return numpy.frombuffer(data, kind).reshape(shape)


def write(data):
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()


scene = EmbreeScene(robust=sys.argv[1] == "robust")
for _ in range(read("<u4", 1)[0]):
    vertices, triangles = read("<u4", 2)
    TriangleMesh(scene, read("<f4", vertices, 3), read("<u4", triangles, 3))
embree = str(EmbreeDevice()).split()[-1]
write(f"embreex {version('embreex')} (Embree {embree}), {sys.argv[1]}\n".encode())

while True:
    occlusion, count = read("<u4", 2)
    rays = read("<f4", count, 7)
    origins, directions = (numpy.ascontiguousarray(part) for part in (rays[:, 0:3], rays[:, 3:6]))
    # A copy that embreex may overwrite with the distances.
    ends = rays[:, 6].copy()
    if occlusion:
        write(scene.run(origins, directions, ends, query="OCCLUDED").astype("<i4").tobytes())
    else:
        found = scene.run(origins, directions, ends, output=True)
        answer = numpy.empty((count, 5), "<f4")
        answer[:, 0] = found["geomID"].astype("<i4").view("<f4")
        answer[:, 1] = found["primID"].astype("<i4").view("<f4")
        answer[:, 2], answer[:, 3], answer[:, 4] = found["tfar"], found["u"], found["v"]
        write(answer.tobytes())
