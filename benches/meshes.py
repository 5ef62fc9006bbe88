"""Meshes out of the files of packages: a reader takes a file's bytes and gives points and faces.

Python 3.9 or later, no package beyond the standard library (but for `simplified`).
"""

import base64
import gzip
import json
import re
import struct

# Edges of the chair's cells in its own units: about as many points as the chair of the biclustering paper has.
CELL = 0.079


class Refused(Exception):
    """Why something cannot be had, in a sentence."""


def ply(mesh):
    """The binary .ply of points and triangles, fitted to a cube of edge 2 around the origin."""
    points, faces = mesh
    low, high = ([bound(point[axis] for point in points) for axis in range(3)] for bound in (min, max))
    scale = 2 / max(h - l for l, h in zip(low, high))
    fitted = [scale * (point[axis] - (low[axis] + high[axis]) / 2) for point in points for axis in range(3)]
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    corners = b"".join(struct.pack("<B3i", 3, *face) for face in faces)
    return header.encode() + struct.pack(f"<{len(fitted)}f", *fitted) + corners


def obj(data):
    points, faces = [], []
    for line in data.decode().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            points.append(tuple(map(float, rest[:3])))
        elif word == "f":
            faces.append(tuple(int(corner.split("/")[0]) - 1 for corner in rest))
    return points, faces


def off(data):
    words = data.decode().split()
    count, faces, numbers = int(words[1]), int(words[2]), words[4:]
    points = [tuple(map(float, numbers[3 * i : 3 * i + 3])) for i in range(count)]
    corners = numbers[3 * count :]
    return points, [tuple(map(int, corners[4 * i + 1 : 4 * i + 4])) for i in range(faces)]


def arrays(data):
    """`exports.positions` and `exports.cells`, written out."""
    return [list(map(tuple, json.loads(text))) for text in re.findall(r"=\s*(\[\[.*?\]\])", data.decode(), re.DOTALL)]


def packed(data):
    """The same as base64 of f32 and u32."""
    points, faces = (base64.b64decode(text) for text in re.findall(r'Array, "([^"]*)"', data.decode()))
    return list(struct.iter_unpack("<3f", points)), list(struct.iter_unpack("<3I", faces))


def scanned(data):
    """An ascii .ply, gzipped, of a surface that is folded in places: a face and the same one turned over leave none, and a point without
    faces is dropped."""
    header, body = gzip.decompress(data).decode().split("end_header\n")
    lines, count = body.splitlines(), int(re.search(r"element vertex (\d+)", header)[1])
    points = [tuple(map(float, line.split())) for line in lines[:count]]
    together = {}
    for line in lines[count:]:
        a, b, c = map(int, line.split()[1:])
        together.setdefault(tuple(sorted((a, b, c))), []).append(min((a, b, c), (b, c, a), (c, a, b)))
    faces = [max(same, key=same.count) for same in together.values() if len(same) % 2]
    kept = sorted({corner for face in faces for corner in face})
    place = {old: new for new, old in enumerate(kept)}
    return [points[old] for old in kept], [tuple(place[corner] for corner in face) for face in faces]


def boxes(data):
    """An .obj of flat quadrilaterals, each as a grid of cells with points of its own."""
    corners, sides = obj(data)
    points, faces = [], []
    for a, b, c, d in ([corners[i] for i in side] for side in sides):
        across = max(1, round(max(length(a, b), length(d, c)) / CELL))
        down = max(1, round(max(length(b, c), length(a, d)) / CELL))
        first = len(points)
        for j in range(down + 1):
            points += [mix(mix(a, b, i / across), mix(d, c, i / across), j / down) for i in range(across + 1)]
        faces += grid(across, down, lambda i, j: first + j * (across + 1) + i)
    return points, faces


def length(a, b):
    return sum((x - y) ** 2 for x, y in zip(a, b)) ** 0.5


def mix(a, b, t):
    return tuple((1 - t) * x + t * y for x, y in zip(a, b))


def grid(across, down, index):
    """Two triangles a cell, but for those with two corners in one."""
    faces = []
    for i, j in ((i, j) for j in range(down) for i in range(across)):
        a, b, c, d = index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)
        faces += [face for face in ((a, b, c), (a, c, d)) if len(set(face)) == 3]
    return faces


def teapot(segments):
    """Of Newell's table: 32 Bezier patches of `segments` x `segments` cells, joined; y points up."""

    def read(data):
        tables = re.findall(r"const teapot(?:Patches|Vertices) = \[(.*?)\]", data.decode(), re.DOTALL)
        patches, numbers = (re.sub(r"/\*.*?\*/|\s", "", table).rstrip(",").split(",") for table in tables)
        patches, numbers = [int(word) for word in patches], [float(word) for word in numbers]
        # Bernstein's polynomials at each step.
        steps = [k / segments for k in range(segments + 1)]
        weights = [((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3) for t in steps]
        points, known, faces = [], {}, []

        def place(patch, u, v):
            x, y, z = (
                sum(weights[v][r] * weights[u][c] * numbers[3 * patch[4 * r + c] + axis] for r in range(4) for c in range(4))
                for axis in range(3)
            )
            # Patches meet up to rounding.
            number = known.setdefault(tuple(round(1e5 * w) for w in (x, y, z)), len(points))
            if number == len(points):
                points.append((x, z, -y))
            return number

        for first in range(0, len(patches), 16):
            patch = patches[first : first + 16]
            at = [[place(patch, u, v) for u in range(segments + 1)] for v in range(segments + 1)]
            faces += grid(segments, segments, lambda u, v: at[v][u])
        return points, faces

    return read


def simplified(vertices):
    """An .obj of which collapsed edges leave so many points."""

    def read(data):
        try:
            import fast_simplification
            import numpy
        except ImportError:
            raise Refused("there is no fast-simplification here: pip install fast-simplification==0.2.0") from None
        points, faces = (numpy.array(array, kind) for array, kind in zip(obj(data), (numpy.float32, numpy.int32)))
        # A closed surface has twice as many faces as points, less four.
        fewer = fast_simplification.simplify(points, faces, target_count=2 * vertices - 4, agg=3)
        return [list(map(tuple, array.tolist())) for array in fewer]

    return read
