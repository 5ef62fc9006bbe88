"""Light transforms: decoded coefficients back to the lights of the basis, and what a transform keeps in memory."""

import math
from functools import lru_cache

import numpy as np

from . import sphere
from .container import check

# A Gaussian lobe is left out of texels on which it is below this share of its peak.
NEGLIGIBLE = 1e-8


def restore(file, name, parameters):
    """The number of coefficients, and a function from rows of them to rows of lights; None where they are the same."""
    if name == "identity":
        return file.lights, None
    check(sphere.is_texels(file.basis), f"{name} on {file.basis}")
    angles = sphere.solid_angles(file.basis)
    if name == "haar":
        on_sphere = parameters.get("scale") == "sphere"
        file.resident += 8 * file.lights // 6 if on_sphere else 0
        return file.lights, lambda rows: unhaar(rows) * (np.sqrt(angles) if on_sphere else 1)
    if name == "sh":
        matrix = harmonic_moments(file.basis, int(parameters.get("order", 5)))
        file.resident += 4 * matrix.size + 8 * file.lights + 8 * len(matrix) ** 2
    else:
        check(name == "srbf", f"transform {name}, known are identity, haar, sh, srbf")
        matrix = srbf_matrix(file, parameters)
    return len(matrix), lambda rows: rows @ matrix


def unhaar(rows):
    """Faces of E² coefficients, from coarse to fine: to texels."""
    edge = math.isqrt(rows.shape[1] // 6)
    faces = rows.reshape(-1, edge * edge)
    image = faces[:, :1].reshape(-1, 1, 1)
    n = 1
    while n < edge:
        horizontal, vertical, diagonal = [faces[:, i * n * n : (i + 1) * n * n].reshape(-1, n, n) for i in (1, 2, 3)]
        finer = np.empty((len(faces), 2 * n, 2 * n))
        for row in (0, 1):
            for column in (0, 1):
                h, v = 1 - 2 * column, 1 - 2 * row
                finer[:, row::2, column::2] = (image + h * horizontal + v * vertical + h * v * diagonal) / 2
        image, n = finer, 2 * n
    return image.reshape(rows.shape)


@lru_cache(maxsize=4)
def harmonic_moments(basis, order):
    return sphere.moments(basis, lambda directions: sphere.harmonics(order, directions))


def icosphere(count):
    """`count` vertices of a subdivided icosahedron, in the page's order."""
    golden = (1 + math.sqrt(5)) / 2
    points = []
    for i in range(3):
        for a, b in [(1, golden), (1, -golden), (-1, golden), (-1, -golden)]:
            point = np.zeros(3)
            point[(i + 1) % 3], point[(i + 2) % 3] = a, b
            points.append(point / np.linalg.norm(point))
    near = np.array(points) @ np.array(points).T > 0.4
    n = range(12)
    faces = [(i, j, k) for i in n for j in n for k in n if i < j < k and near[i, j] and near[j, k] and near[i, k]]
    while len(points) < count:
        middles, finer = {}, []

        def middle(i, j):
            key = (min(i, j), max(i, j))
            if key not in middles:
                middles[key] = len(points)
                point = points[i] + points[j]
                points.append(point / np.linalg.norm(point))
            return middles[key]

        for i, j, k in faces:
            a, b, c = middle(i, j), middle(j, k), middle(k, i)
            finer += [(i, a, c), (j, b, a), (k, c, b), (a, b, c)]
        faces = finer
    check(len(points) == count, f"{count} centres are no subdivided icosahedron")
    return np.array(points)


def least_angle(centres):
    cosines = centres @ centres.T
    np.fill_diagonal(cosines, -1)
    return math.acos(cosines.max())


def spread(kernel, bandwidth):
    m = 1 / math.tanh(2 * bandwidth) - 1 / (2 * bandwidth) if kernel == "gaussian" else 2 * bandwidth / (1 + bandwidth**2)
    return math.sqrt(m**-2 - 1)


def usual_bandwidth(kernel, centres):
    """λ whose spread is to π/40 as the least angle is to that of 642 centres; spreads fall with λ."""
    goal = math.pi / 40 * least_angle(centres) / least_angle(icosphere(642))
    low, high = 1e-3, 1e6 if kernel == "gaussian" else 1 - 1e-12
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if spread(kernel, middle) > goal else (low, middle)
    return low


def srbf_matrix(file, parameters):
    """What turns coefficients into lights: B, or L⁻¹ B."""
    kernel, given = parameters.get("kernel", "gaussian"), parameters.get("centers") == "given"
    check(kernel in ("gaussian", "abel-poisson"), f"kernel {kernel}")
    if given:
        bandwidths = file.take("basis/srbf-bandwidths", "f8")
        centres = file.take("basis/srbf-centers", "f8", 3 * len(bandwidths)).reshape(-1, 3)
    else:
        centres = icosphere(int(parameters.get("centers", 642)))
        bandwidth = float(parameters["bandwidth"]) if "bandwidth" in parameters else usual_bandwidth(kernel, centres)
        bandwidths = np.full(len(centres), bandwidth)
    ridge = parameters.get("ridge", "auto")
    if ridge == "auto":
        ridge = file.take("header/srbf-ridge", "f8", 1)[0] if file.has("header/srbf-ridge") else 0.0
    n, lobes = len(centres), (kernel, centres.tobytes(), bandwidths.tobytes())
    count = np.count_nonzero(lobe_moments(file.basis, *lobes))
    file.resident += (0 if given else 32 * n) + 4 * (file.lights + 1) + 6 * count + 8 * file.lights + 4 * n * (n + 1)
    return lobe_coordinates(file.basis, lobes, float(ridge), parameters.get("coordinates", "orthonormal"))


@lru_cache(maxsize=4)
def lobe_coordinates(basis, lobes, ridge, coordinates):
    b = lobe_moments(basis, *lobes)
    if coordinates == "lobes":
        return b
    gram = b / sphere.solid_angles(basis) @ b.T
    gram += ridge * gram.diagonal().mean() * np.eye(len(gram))
    return np.linalg.solve(np.linalg.cholesky(gram), b)


@lru_cache(maxsize=4)
def lobe_moments(basis, kernel, centres, bandwidths):
    """B. A Gaussian that is negligible on all of a texel has none there."""
    centres, l = np.frombuffer(centres).reshape(-1, 3), np.frombuffer(bandwidths)[:, None]

    def lobes(directions):
        cosine = centres @ directions
        return np.exp(l * (cosine - 1)) if kernel == "gaussian" else (1 - l * l) / (1 - 2 * l * cosine + l * l) ** 1.5

    b = sphere.moments(basis, lobes)
    if kernel == "gaussian":
        reach = np.arccos(np.maximum(1 + math.log(NEGLIGIBLE) / l, -1)) + sphere.radius(basis)
        b[centres @ sphere.places(basis, 0.5, 0.5)[0] < np.cos(np.minimum(reach, np.pi))] = 0
    return b
