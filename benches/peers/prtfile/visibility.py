"""The codec `visibility`: what differs from the horizon's prediction, run by run along a scan of the cubemap."""

import numpy as np

from .container import check
from .elements import before, width
from .rows import Sparse
from .sphere import FACES

# Samples that are decoded together.
SAMPLES = 16


def dot(a, b):
    """Products before sums, left to right, as the page says: a last bit could decide a comparison otherwise."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def read_visibility(file, lights):
    samples, responses, edge = file.samples, file.responses, round((file.lights / 6) ** 0.5)
    check(file.basis == f"cubemap:{edge}" and lights == file.lights, "visibility on something else than a cubemap")
    k, *widths = file.take("header/layout", "i4", 3).tolist()
    check(1 <= k <= 16, f"{k} samples along an edge")
    directions = file.take("basis/directions", "f4", 3 * responses).reshape(-1, 3).astype(float)
    frames = frame_rows(file.take("basis/frames", "i2", 4 * samples).reshape(-1, 4).astype(float))
    levels = file.take("weights/levels", "f4")
    check(len(levels) <= 4096 and (np.diff(levels) > 0).all() and (levels != 0).all(), "weights/levels")
    symbols = columns_of_symbols(file, samples, lights, edge, widths, 2 + 2 * len(levels))
    exceptions = file.take("index/exceptions", "u4").reshape(-1, 3).astype(np.int64)
    check((exceptions < [samples, lights, responses]).all(), "index/exceptions")
    rows, columns, values = [], [], []
    centres, right, down = texels(edge)
    for first in range(0, samples, SAMPLES):
        chosen = slice(first, min(first + SAMPLES, samples))
        frame = frames[:, :, chosen, None]
        above = samples_above(frame[2], centres, right, down, edge, k)
        value = values_of(symbols[chosen], above, levels, k)
        sample, column = np.nonzero(value)
        x = [dot(frames[i][:, first + sample], centres[:, column]) for i in range(3)]
        x[2] = np.maximum(x[2], 0)
        rows.append(responses * (first + sample) + nearest(directions, x))
        columns.append(column)
        values.append(value[sample, column])
    rows, columns, values = map(np.concatenate, (rows, columns, values))
    rows = move(rows, columns, exceptions, responses, lights)
    return Sparse.of_elements(file.rows, lights, rows, columns, values)


def frame_rows(quaternions):
    """row x coordinate x sample."""
    w, x, y, z = quaternions.T
    check((quaternions != 0).any(1).all(), "a quaternion of length 0")
    s = 2 / (w * w + x * x + y * y + z * z)
    return np.array(
        [
            [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
        ]
    )


def columns_of_symbols(file, samples, lights, edge, widths, limit):
    """The symbol of each sample and light."""
    counts = file.take("index/counts", width(widths[0]), samples).astype(np.int64)
    check((file.take("index/starts", "u8", -(-samples // 64)) == before(counts)).all(), "index/starts")
    lengths = file.take("index/lengths", "u1", counts.sum()).astype(np.int64) + 1
    stored = file.take("weights/symbols", width(widths[1]), counts.sum())
    check(len(stored) == 0 or stored.max() < limit, "a symbol that does not exist")
    ends = np.append(0, np.cumsum(lengths))[np.append(0, np.cumsum(counts))]
    check((ends == lights * np.arange(samples + 1)).all(), "runs of a sample that do not add up to the lights")
    scan = np.arange(lights).reshape(6, edge, edge)
    scan[:, 1::2] = scan[:, 1::2, ::-1]
    symbols = np.empty((samples, lights), np.int64)
    symbols[:, scan.ravel()] = np.repeat(stored, lengths).reshape(samples, lights)
    return symbols


def texels(edge):
    """Centres, and the axes right and down of their faces: coordinate x light."""
    at = (2 * np.arange(edge) + 1) * (1 / edge) - 1
    face, v, u = np.meshgrid(np.arange(6), at, at, indexing="ij")
    forward, right, down = [FACES[face.ravel(), i].T for i in range(3)]
    return (forward + v.ravel() * down) + u.ravel() * right, right, down


def samples_above(normal, centres, right, down, edge, k):
    """How many of the k² samples of each texel are above the horizon: sample x light."""
    h = dot(normal, centres)
    above = np.where(h > 0, k * k, 0)
    near = np.nonzero(np.abs(h) <= 1.5 * (1 / edge))
    h = h[near]
    across, along = [dot(axes, normal)[near] * (1 / edge) for axes in (right, down)]
    offsets = (2 * np.arange(k) + 1) / k - 1
    count = np.zeros(len(h), int)
    for a in offsets:
        for b in offsets:
            count += h + a * across + b * along > 0
    above[near] = count
    return above


def values_of(symbols, above, levels, k):
    n = len(levels)
    if n == 0:
        return np.zeros(symbols.shape, np.float32)
    share = above.astype(np.float32) / np.float32(k * k)
    predicted = np.where(above > 0, levels[np.minimum(np.searchsorted(levels, share), n - 1)], 0)
    level = levels[(symbols - 2) % n]
    return np.select([symbols == 0, symbols == 1, symbols < 2 + n], [predicted, 0, np.where(above > 0, level, 0)], level)


def nearest(directions, x):
    """The direction of the largest product with each x, the first of several."""
    best, product = np.zeros(len(x[0]), np.int64), np.full(len(x[0]), -np.inf)
    for i, direction in enumerate(directions):
        here = dot(direction, x)
        best[here > product] = i
        product = np.maximum(product, here)
    return best


def move(rows, columns, exceptions, responses, lights):
    """Elements that an exception names, to the rows it says. A sample has a column at most once."""
    samples, column, response = exceptions.T
    keys, named = rows // responses * lights + columns, samples * lights + column
    check((np.diff(named) > 0).all(), "index/exceptions do not ascend")
    place = np.searchsorted(keys, named)
    check((place < len(keys)).all() and (keys[place] == named).all(), "an exception for an element that is 0")
    rows = rows.copy()
    rows[place] = samples * responses + response
    return rows
