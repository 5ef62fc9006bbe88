"""The archive form of `bicluster`: elements by runs, and the pairs of symbols from which the arrays in memory follow."""

import numpy as np

from .container import check
from .rows import Sparse, ranges

NOTHING_SHARED = 2**32 - 1
# Rows of a block, and leaves.
ROWS, LEAVES = 8192, 32768


def planes(file, name, limit, count=None):
    """Numbers up to `limit`, all of their lowest bytes first."""
    each = max(1, (int(limit).bit_length() + 7) // 8)
    stored = file.take(name, "u1", None if count is None else each * count)
    check(len(stored) % each == 0, f"{name}: {len(stored)} bytes")
    return sum(plane.astype(np.int64) << (8 * i) for i, plane in enumerate(stored.reshape(each, -1)))


def read_archive(file, lights):
    (together,) = file.take("header/listing", "u4", 1).tolist()
    check(together in (1, file.responses), f"{together} rows listed together")
    counts = planes(file, "index/counts", NOTHING_SHARED, file.rows // together)
    runs = counts.sum()
    gaps, lengths = [planes(file, name, lights, runs) for name in ("index/gaps", "index/lengths")]
    row = planes(file, "index/rows", together - 1, runs) + together * np.repeat(np.arange(len(counts)), counts)
    check((lengths > 0).all() and (row < file.rows).all(), "a run without elements, or of no row")
    # Columns since the end of the run before, or since the first column where there is none in the listing.
    ends = np.cumsum(gaps + lengths)
    starts = ends - lengths - np.repeat(np.append(0, ends)[np.cumsum(counts) - counts], counts)
    table = file.take("weights/table", "f4")
    steps = planes(file, "index/steps", NOTHING_SHARED)
    codes = planes(file, "index/codes", len(table), len(steps))
    places = np.cumsum(steps) - 1
    value = np.zeros(lengths.sum(), int)
    exceptions = len(steps) == 0 or (steps.min() > 0 and places[-1] < len(value) and codes.max() + 1 < len(table))
    check(exceptions, "an exception of no element, or beyond the table")
    value[places] = codes + 1
    columns = np.repeat(starts, lengths) + ranges(lengths)
    matrix = Sparse.of_elements(file.rows, lights, np.repeat(row, lengths), columns, table[value])
    file.resident = bytes_of_arrays(file, matrix)
    return matrix


def bytes_of_arrays(file, matrix):
    """What memory holds of an archive: the lengths of the arrays that follow from it."""
    regions = file.take("index/regions", "u2", matrix.lights)
    pairs = file.take("index/pairs", "u4").astype(np.int64)
    sums = np.where(pairs == NOTHING_SHARED, 0, pairs)
    first, second = [planes(file, name, 65535, sums.sum()) for name in ("index/first", "index/second")]
    first = np.cumsum(first) % 65536
    second, starts = (first + second) % 65536, np.cumsum(sums) - sums
    products = distinct_rows(matrix)
    region = regions[matrix.columns[[p[len(p) // 2] for p in products]]] if products else np.zeros(0, int)
    of_regions = [np.flatnonzero(region == r) for r in np.unique(region)]
    blocks = [rows[at : at + ROWS] for rows in of_regions for at in range(0, len(rows), ROWS)]
    check(len(blocks) == len(pairs), f"index/pairs: {len(pairs)} blocks, expected {len(blocks)}")
    total, rest_lengths, rest_values = 4 * matrix.count + 2 * matrix.lights + 12 * len(blocks), [], []
    for block, start, count, shares in zip(blocks, starts, sums, pairs != NOTHING_SHARED):
        place = np.concatenate([products[p] for p in block])
        row = np.repeat(np.arange(len(block)), [len(products[p]) for p in block])
        leaf, runs, leaves = leaves_of(matrix, place, len(block)) if shares else (np.full(len(place), -1), 0, 0)
        rest_lengths.append(np.bincount(row[leaf < 0], minlength=len(block)))
        rest_values.append(matrix.values[place[leaf < 0]])
        of_block = slice(start, start + count)
        left = merge(row[leaf >= 0], leaf[leaf >= 0], len(block), leaves, zip(first[of_block].tolist(), second[of_block].tolist()))
        groups = len(np.unique(left[left > 0]))
        total += 8 * runs + (2 if matrix.lights <= 65536 else 4) * leaves + 4 * count + 8 * groups + 2 * left.sum()
    lengths, values = [np.concatenate([np.zeros(0, int), *parts]) for parts in (rest_lengths, rest_values)]
    return int(total) + (4 + bytes_of_compact(lengths, values, matrix.lights) if len(values) else 0)


def distinct_rows(matrix):
    """The elements of each row that is not zeros and not equal to one before."""
    found, values = {}, matrix.values.astype("f4")
    for begin, end in zip(matrix.offsets[:-1], matrix.offsets[1:]):
        if begin < end:
            found.setdefault((matrix.columns[begin:end].tobytes(), values[begin:end].tobytes()), np.arange(begin, end))
    return list(found.values())


def leaves_of(matrix, place, rows):
    """For each of these elements of a block its leaf, or -1; runs of equal values; leaves."""
    values, columns = matrix.values[place].astype("f4"), matrix.columns[place]
    order = np.where(values == 1, 0, values.view("u4").astype(np.int64) + 1)
    keys, which, counts = np.unique(order * matrix.lights + columns, return_inverse=True, return_counts=True)
    least = 2 if np.count_nonzero(counts == 1) > rows else 1
    chosen = np.flatnonzero(counts >= least)
    chosen = np.sort(chosen[np.argsort(-counts[chosen], kind="stable")][:LEAVES])
    number = np.full(len(keys), -1)
    number[chosen] = np.arange(len(chosen))
    return number[which], len(np.unique(keys[chosen] // matrix.lights)), len(chosen)


def merge(row, leaf, rows, leaves, pairs):
    """How many terms are left of each row when pairs of its symbols have become sums; `row` has the leaf `leaf`."""
    members = [set() for _ in range(leaves)]
    for i, symbol in zip(row.tolist(), leaf.tolist()):
        members[symbol].add(i)
    left = np.bincount(row, minlength=rows)
    for a, b in pairs:
        check(a != b and max(a, b) < len(members), "index/first, index/second: a symbol that comes later")
        both = members[a] & members[b]
        members[a] -= both
        members[b] -= both
        members.append(both)
        left[list(both)] -= 1
    return left


def bytes_of_compact(lengths, values, lights):
    """What the sections of `compact` take of rows of so many elements, in the narrowest exact widths."""
    rows, n = len(lengths), len(values)
    lengths = n * narrowest(lights - 1) + rows * narrowest(lengths.max()) + 8 * -(-rows // 64)
    sparse = lengths + bytes_of_values(values, n)
    zeros = np.zeros(1 if n < rows * lights else 0)
    return 16 + min(sparse, bytes_of_values(np.append(values, zeros), rows * lights))


def narrowest(largest):
    return 1 if largest < 256 else 2 if largest < 65536 else 4


def bytes_of_values(values, count):
    """`count` numbers out of `values` in the narrowest of the forms of `compact`."""
    distinct = np.unique(values)
    mantissa, exponent = np.frexp(distinct[distinct != 0])
    whole = np.abs(mantissa * 2**24).astype(np.int64)
    # Exponents of the lowest bit that is set, and of the place after the highest.
    lowest = exponent - 24 + np.log2(whole & -whole).astype(int)
    integers = np.ldexp(distinct, -lowest.min()) if len(lowest) else distinct

    def fits(bits):
        low, high = integers.min(), integers.max()
        return (low >= 0 and high < 2**bits) or (low >= -(2 ** (bits - 1)) and high < 2 ** (bits - 1))

    halves = len(lowest) == 0 or ((exponent - lowest).max() <= 11 and exponent.max() - lowest.min() <= 40)
    table = 4 * len(distinct)
    sizes = [(4 * count, True), (count, fits(8)), (2 * count, fits(16) or halves)]
    sizes += [(count + table, len(distinct) <= 256), (2 * count + table, len(distinct) <= 65536)]
    return min(size for size, possible in sizes if possible)
