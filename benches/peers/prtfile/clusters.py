"""Codecs that share a basis among samples: cpca (vq, pca), cta (tucker), slf."""

import math

import numpy as np

from .container import check
from .rows import Lazy, ranges

WIDTHS = ["f4", "f2", "i2"]
# Samples between two places that memory holds beside a file.
STRIDE = 64


def members_of(file, name, count, clusters):
    """Numbers below `clusters` in the fewest bits, lowest bits first."""
    bits = (max(clusters, 1) - 1).bit_length()
    if bits == 0:
        return np.zeros(count, int)
    packed = np.unpackbits(file.take(name, "u1", -(-count * bits // 8)), bitorder="little")
    check(not packed[count * bits :].any(), f"{name}: bits after the last")
    members = packed[: count * bits].reshape(count, bits).astype(int) @ (1 << np.arange(bits))
    check((members < clusters).all(), f"{name}: a cluster that does not exist")
    return members


def counts_of(file, name, clusters, each=1):
    """`each` numbers for every cluster, or the same for all; and whether they differ."""
    stored = file.take(name, "u4").astype(int)
    check(len(stored) in (each, each * clusters), f"{name}: {len(stored)} numbers for {clusters} clusters")
    return np.broadcast_to(stored.reshape(-1, each), (clusters, each)).T, len(stored) > each


def numbers(file, name, scales, width, vector, vectors, shape, by_scale=False):
    """Numbers of a shape: what is stored times the scale of its vector, of so many; `vector` is repeated to the shape. With `by_scale` i16 lie
    vector by vector in ascending order of scales, their lower bytes first. Exact in f32."""
    check(width < len(WIDTHS), f"{name}: width {width}")
    count = math.prod(shape)
    if width == 0:
        return file.take(name, "f4", count).reshape(shape)
    scales = file.take(scales, "f4", vectors)
    check((scales >= 0).all(), f"{name}: a scale below 0")
    if not (by_scale and width == 2):
        return file.take(name, WIDTHS[width], count).reshape(shape).astype("f4") * scales[vector]
    low, high = file.take(name, "u1", 2 * count).reshape(2, count).astype("u2")
    rank = np.argsort(np.argsort(scales, kind="stable"))
    stored = np.empty(count, "i2")
    stored[np.argsort(np.broadcast_to(rank[vector], shape).ravel(), kind="stable")] = (low + (high << 8)).view("i2")
    return stored.reshape(shape).astype("f4") * scales[vector]


def product(a, b):
    return a.astype(float) @ b.astype(float)


def read_cpca(file, lights):
    samples, n = file.samples, file.responses * lights
    clusters, *widths = file.take("header/layout", "u4", 3).tolist()
    (components,), differ = counts_of(file, "index/components", clusters)
    members = members_of(file, "index/members", samples, clusters)
    if file.has("index/superclusters"):
        file.take("index/superclusters", "u4", clusters)
    vectors = clusters + int(components.sum())
    first = np.cumsum(1 + components) - (1 + components)
    each = np.arange(vectors)[:, None]
    representatives = numbers(file, "basis/representatives", "basis/scales", widths[0], each, vectors, (vectors, n))
    of_sample = components[members]
    start = np.cumsum(of_sample) - of_sample
    component = np.repeat((first - np.arange(clusters))[members], of_sample) + ranges(of_sample)
    weights = numbers(file, "weights/weights", "weights/scales", widths[1], component, vectors - clusters, component.shape)
    file.resident += 8 * (clusters + samples // STRIDE + 1) if differ else 0

    def block(begin, end):
        chosen = slice(begin // file.responses, end // file.responses)
        out = np.empty((chosen.stop - chosen.start, n))
        for cluster in np.unique(members[chosen]):
            mine = np.flatnonzero(members[chosen] == cluster)
            mean, count = first[cluster], components[cluster]
            w = weights[start[chosen][mine][:, None] + np.arange(count)]
            out[mine] = representatives[mean] + product(w, representatives[mean + 1 : mean + 1 + count])
        return out.reshape(-1, lights)

    return Lazy(file.rows, lights, block)


def read_cta(file, lights):
    samples, responses = file.samples, file.responses
    clusters, m, views, width = file.take("header/layout", "u4", 4).tolist()
    check(1 <= views <= responses and m >= 1, f"{views} views, {m} clusters of a sample")
    view = file.take("basis/view", "f4", responses * views).reshape(responses, views) if file.has("basis/view") else np.eye(responses)
    check(view.shape[1] == views, "no view basis")
    (light_ranks, sample_ranks), differ = counts_of(file, "index/ranks", clusters, 2)
    members = members_of(file, "index/members", samples * m, clusters)
    all_light, all_dual = int(light_ranks.sum()), int(sample_ranks.sum())
    each = np.arange(all_light)[:, None]
    light = numbers(file, "basis/light", "basis/light-scales", width, each, all_light, (all_light, lights), True)
    row = np.repeat(np.arange(all_dual), np.repeat(views * light_ranks, sample_ranks))
    dual = numbers(file, "basis/dual", "basis/dual-scales", width, row, all_dual, row.shape, True)
    of_member = sample_ranks[members]
    row = np.repeat((np.cumsum(sample_ranks) - sample_ranks)[members], of_member) + ranges(of_member)
    weights = numbers(file, "weights/weights", "weights/scales", width, row, all_dual, row.shape, True)
    light_start, dual_start = [np.append(0, np.cumsum(n)) for n in (light_ranks, views * light_ranks * sample_ranks)]
    start = (np.cumsum(of_member) - of_member).reshape(samples, m)
    members = members.reshape(samples, m)
    file.resident += 8 * (5 * clusters + (samples // STRIDE + 1 if differ else 0))

    def block(begin, end):
        chosen = slice(begin // responses, end // responses)
        out = np.zeros((chosen.stop - chosen.start, views, lights))
        for cluster in np.unique(members[chosen]):
            mine, place = np.nonzero(members[chosen] == cluster)
            s, r = sample_ranks[cluster], light_ranks[cluster]
            w = weights[start[chosen][mine, place][:, None] + np.arange(s)]
            v = dual[dual_start[cluster] : dual_start[cluster + 1]].reshape(s, views * r)
            part = product(w, v).reshape(len(mine), views, r)
            np.add.at(out, mine, product(part, light[light_start[cluster] : light_start[cluster + 1]]))
        return product(view, out).reshape(-1, lights)

    return Lazy(file.rows, lights, block)


def read_slf(file, lights):
    m, channels = file.samples, file.responses
    layout = file.take("header/layout", "u4").tolist()
    check(len(layout) >= 5 and layout[0] <= 2, "header/layout")
    colour, k, surface_width, views_width, *eta = layout
    separate, joint = colour == 1, colour == 2
    fields, parts = (channels, 1) if separate else (1, channels)
    check(len(eta) == fields, f"{len(eta)} fields, expected {fields}")
    of_fields = members_of(file, "index/clusters", m * fields, max(eta)).reshape(m, fields)
    check((of_fields < eta).all(), "index/clusters: a cluster that does not exist")
    # For each texel and channel its cluster, numbered through all fields, and which part of that cluster it meets.
    cluster = np.broadcast_to(of_fields + np.cumsum(eta) - eta, (m, channels))
    part = np.zeros(channels, int) if separate else np.arange(channels)
    all_clusters, of_texel = sum(eta), 1 if joint else channels
    shapes = (m, of_texel, k), (all_clusters, lights, parts, k), (m, channels)
    if file.has("header/maps"):
        surface, views, mean = slf_maps(file, *shapes)
    else:
        of_mean = cluster * parts + part
        of_surface = (cluster[:, :1] if joint else of_mean)[:, :, None] * k + np.arange(k)
        of_views = np.arange(all_clusters * parts * k).reshape(all_clusters, 1, parts, k)
        vectors = [all_clusters * k * (1 if joint else parts), all_clusters * parts * k, all_clusters * parts]
        surface = numbers(file, "weights/surface", "weights/surface-scales", surface_width, of_surface, vectors[0], shapes[0])
        views = numbers(file, "basis/views", "basis/views-scales", views_width, of_views, vectors[1], shapes[1])
        mean = numbers(file, "weights/mean", "weights/mean-scales", surface_width, of_mean, vectors[2], shapes[2])

    def block(begin, end):
        chosen = slice(begin // channels, end // channels)
        out = np.repeat(mean[chosen, :, None].astype(float), lights, 2)
        for z in range(channels):
            for c in np.unique(cluster[chosen, z]):
                mine = np.flatnonzero(cluster[chosen, z] == c)
                out[mine, z] += product(surface[chosen][mine, 0 if joint else z], views[c, :, part[z]].T)
        return out.reshape(-1, lights)

    return Lazy(file.rows, lights, block)


def slf_maps(file, surface, views, mean):
    """Surface map, view maps and mean map of these shapes, kept as images."""
    (m, of_texel, k), (clusters, lights, parts, _), (_, channels) = surface, views, mean
    x, y, z, w, flags = file.take("header/maps", "u4", 5).tolist()
    check((x * y, z * w) == (m, lights), f"maps of {x} x {y} texels and {z} x {w} directions")

    def images(name, count, height, width, flag):
        each = np.arange(count)[:, None, None]
        stack = numbers(file, name, f"{name}-scales", 2, each, count, (count, height, width), True)
        file.resident += 2 * stack.size
        return (unhaar(stack) if flags & flag else stack).reshape(count, height * width)

    surface = images("weights/surface", of_texel * k, y, x, 1).T.reshape(surface)
    views = images("basis/views", clusters * parts * k, w, z, 2).reshape(clusters, parts, k, lights).transpose(0, 3, 1, 2)
    return surface, views, images("weights/mean", channels, y, x, 4).T


def unhaar(images):
    """A stack of images out of the Haar basis, from the coarsest level to the finest."""
    levels = [(np.ones(images.shape[1]), np.ones(images.shape[2]))]
    while max(map(len, levels[-1])) > 1:
        levels.append(tuple(np.add.reduceat(pixels, np.arange(0, len(pixels), 2)) for pixels in levels[-1]))
    images = images.astype(float)
    for rows, columns in reversed(levels[:-1]):
        corner = images[:, : len(rows), : len(columns)]
        images[:, : len(rows), : len(columns)] = undo_step(undo_step(corner, 1, rows), 2, columns)
    return images


def undo_step(images, axis, pixels):
    """Neighbours out of their common parts, which come first, and their differences; entries of a line stand for so many `pixels`."""
    lines = np.moveaxis(images, axis, -1)
    n, half = len(pixels), len(pixels) // 2
    s, t = pixels[: 2 * half].reshape(half, 2).T
    common, last, differences = lines[..., :half], lines[..., half : n - half], lines[..., n - half :]
    out = np.empty_like(lines)
    out[..., 0 : 2 * half : 2] = (np.sqrt(s) * common + np.sqrt(t) * differences) / np.sqrt(s + t)
    out[..., 1 : 2 * half : 2] = (np.sqrt(t) * common - np.sqrt(s) * differences) / np.sqrt(s + t)
    out[..., 2 * half :] = last
    return np.moveaxis(out, -1, axis)
