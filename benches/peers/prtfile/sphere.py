"""Where the lights of a basis lie, what they measure of a function, and real spherical harmonics."""

import math
from functools import lru_cache

import numpy as np

# forward, right, down of +x, -x, +y, -y, +z, -z
FACES = np.array(
    [
        [[1, 0, 0], [0, 0, -1], [0, -1, 0]],
        [[-1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[0, 1, 0], [1, 0, 0], [0, 0, 1]],
        [[0, -1, 0], [1, 0, 0], [0, 0, -1]],
        [[0, 0, 1], [1, 0, 0], [0, -1, 0]],
        [[0, 0, -1], [-1, 0, 0], [0, -1, 0]],
    ],
    float,
)


def size_of(basis):
    """Kind and size of a light basis: texels along x and y, or a number."""
    kind, size = basis.split(":")[:2]
    return kind, [int(n) for n in size.split("x")]


def is_texels(basis):
    return basis.startswith(("cubemap:", "latlong:"))


def places(basis, s, t):
    """Directions at the place (s, t) in [0, 1]² of each texel, 3 x lights, and the solid angle for an area there."""
    kind, size = size_of(basis)
    if kind == "cubemap":
        n = size[0]
        face, row, column = np.unravel_index(np.arange(6 * n * n), (6, n, n))
        u, v = 2 * (column + s) / n - 1, 2 * (row + t) / n - 1
        forward, right, down = FACES[face].transpose(1, 2, 0)
        norm = np.sqrt(1 + u * u + v * v)
        return (forward + u * right + v * down) / norm, 4 / n**2 / norm**3
    width, height = size
    row, column = np.unravel_index(np.arange(width * height), (height, width))
    phi, theta = np.pi - 2 * np.pi * (column + s) / width, np.pi * (row + t) / height
    directions = [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
    return np.array(directions), np.sin(theta) * 2 * np.pi**2 / (width * height)


def radius(basis):
    """An angle around its centre within which all of a texel lies."""
    kind, size = size_of(basis)
    return math.sqrt(2) / size[0] if kind == "cubemap" else math.pi / size[0] + math.pi / (2 * size[1])


@lru_cache(maxsize=8)
def solid_angles(basis):
    """Of each texel: exactly, of a cubemap as two spherical triangles (Van Oosterom and Strackee)."""
    kind, size = size_of(basis)
    if kind == "latlong":
        rings = np.cos(np.pi * np.arange(size[1] + 1) / size[1])
        return np.repeat((rings[:-1] - rings[1:]) * 2 * np.pi / size[0], size[0])
    a, b, c, d = [places(basis, s, t)[0] for s, t in [(0, 0), (1, 0), (1, 1), (0, 1)]]

    def triangle(a, b, c):
        dot = [(p * q).sum(0) for p, q in [(a, b), (b, c), (c, a)]]
        return 2 * np.arctan2(np.abs((a * np.cross(b, c, axis=0)).sum(0)), 1 + sum(dot))

    return triangle(a, b, c) + triangle(a, c, d)


def moments(basis, functions):
    """Integrals over each texel of functions of directions, 3 x n, to count x n: count x lights."""
    last, n = None, 4
    while True:
        nodes, weights = np.polynomial.legendre.leggauss(n)
        out = 0
        for i in range(n):
            for j in range(n):
                directions, angle = places(basis, (1 + nodes[i]) / 2, (1 + nodes[j]) / 2)
                values = functions(directions)
                values *= angle * (weights[i] * weights[j] / 4)
                out += values
        # What is left after half as many nodes again is far below what they changed.
        if last is not None and np.abs(out - last).max() <= 1e-7 * np.abs(out).max():
            return out
        last, n = out, n * 3 // 2


def harmonics(order, directions):
    """Real spherical harmonics of bands below `order`, l(l + 1) + m: orthonormal, without the Condon-Shortley phase; cosines for m > 0, sines below."""
    x, y, z = directions
    out = np.empty((order * order, len(z)))
    around, top = np.ones(len(z), complex), np.full(len(z), math.sqrt(1 / (4 * math.pi)))
    for m in range(order):
        before, here = np.zeros(len(z)), top
        for l in range(m, order):
            if l > m:
                a = math.sqrt((4 * l * l - 1) / (l * l - m * m))
                b = math.sqrt(((l - 1) ** 2 - m * m) / (4 * (l - 1) ** 2 - 1)) if l > m + 1 else 0.0
                before, here = here, a * (z * here - b * before)
            scale = math.sqrt(2) if m else 1.0
            out[l * (l + 1) + m] = scale * here * around.real
            if m:
                out[l * (l + 1) - m] = scale * here * around.imag
        around, top = around * (x + 1j * y), top * math.sqrt((2 * m + 3) / (2 * m + 2))
    return out


@lru_cache(maxsize=8)
def exit_gram(count):
    """∫ y_r y_q over the hemisphere z ≥ 0 of the `count` functions of `exit:N`: exact, since all are polynomials."""
    order = math.isqrt(count + 1)
    nodes, weights = np.polynomial.legendre.leggauss(2 * order)
    turns = 4 * order
    z = np.repeat((1 + nodes) / 2, turns)
    weight = np.repeat(weights / 2, turns) * 2 * math.pi / turns
    phi = np.tile(2 * math.pi * np.arange(turns) / turns, len(nodes))
    r = np.sqrt(1 - z * z)
    y = harmonics(order, [r * np.cos(phi), r * np.sin(phi), z])
    if count < order * order:
        y = np.delete(y, 2, 0)
    return (y * weight) @ y.T
