"""The codec `bicluster`: products that are sums of symbols, which are leaves and sums of symbols."""

import numpy as np

from .archive import read_archive
from .container import check
from .elements import read_compact
from .rows import Sparse, ranges


class Tape:
    """Hands out an array part by part."""

    def __init__(self, array):
        self.array, self.at = array, 0

    def __call__(self, count):
        part = self.array[self.at : self.at + count]
        check(len(part) == count, "index/: a block longer than its sections")
        self.at += count
        return part


def read_bicluster(file, lights):
    if file.has("index/slots"):
        return read_arrays(file, lights)
    return read_archive(file, lights) if file.has("index/pairs") else read_compact(file, lights)


def read_arrays(file, lights):
    blocks = file.take("index/blocks", "u4").reshape(-1, 3).astype(int)
    runs, sums, groups = blocks.sum(0)
    factors, ends = file.take("weights/factors", "f4", runs), file.take("index/runs", "u4", runs).astype(int)
    columns = file.take("index/columns", "u2" if lights <= 65536 else "u4").astype(int)
    arities = file.take("index/arities", "u2", sums).astype(int) if file.has("index/arities") else np.full(sums, 2)
    inputs = file.take("index/inputs", "u2", arities.sum())
    groups = file.take("index/groups", "u4", 2 * groups).reshape(-1, 2).astype(int)
    terms = file.take("index/terms", "u2", groups.prod(1).sum())
    check((arities >= 2).all() and (groups[:, 0] >= 1).all(), "a sum of fewer than two symbols, or a product without terms")
    factors, ends, columns, arities, inputs, groups, terms = map(Tape, (factors, ends, columns, arities, inputs, groups, terms))
    # Columns and factors of each product's leaves.
    products = []
    for runs, sums, count in blocks:
        end = ends(runs)
        lengths = np.diff(end, prepend=0)
        check((lengths > 0).all(), "index/runs: a run without leaves")
        column, factor = columns(lengths.sum()), np.repeat(factors(runs), lengths)
        symbols = symbols_of(len(column), [inputs(arity) for arity in arities(sums)], 256 * min(len(column), lights))
        for row in rows_of_terms(groups(count), terms, len(symbols)):
            leaves = np.concatenate([symbols[i] for i in row])
            products.append((column[leaves], factor[leaves]))
    check(columns.at == len(columns.array), "index/columns: leaves of no block")
    return pick(summed(file, lights, products), file.take("index/slots", "u4", file.rows).astype(int))


def symbols_of(leaves, sums, most):
    """The leaves of each symbol of a block."""
    symbols = list(np.arange(leaves)[:, None])
    for inputs in sums:
        check(inputs.max() < len(symbols), "index/inputs: a symbol that comes later")
        symbols.append(np.concatenate([symbols[i] for i in inputs]))
        check(len(symbols[-1]) <= most, "a sum of too many leaves")
    return symbols


def rows_of_terms(groups, terms, symbols):
    """The terms of each product of a block: eight products are interleaved as long as there are eight."""
    for length, products in groups:
        eights = terms(products // 8 * 8 * length).reshape(-1, length, 8).transpose(0, 2, 1).reshape(-1, length)
        alone = terms(products % 8 * length).reshape(-1, length)
        for row in (*eights, *alone):
            check(row.max() < symbols, "index/terms: a symbol that does not exist")
            yield row


def summed(file, lights, products):
    """A row for each product: its leaves, some of which take away what a sum has and the row has not, and the elements of `rest`."""
    count = len(products)
    rows = np.repeat(np.arange(count), [len(columns) for columns, _ in products])
    columns, values = map(np.concatenate, zip(*products)) if products else (np.zeros(0, int), np.zeros(0))
    if file.has("header/products"):
        (count,) = file.take("header/products", "u4", 1).tolist()
        rest = read_compact(file, lights, count, "rest-").block(0, count)
        place = np.nonzero(rest)
        rows, columns, values = [np.concatenate(pair) for pair in zip((rows, columns, values), (*place, rest[place]))]
    keys, place = np.unique(rows * lights + columns, return_inverse=True)
    return Sparse.of_keys(count, lights, keys, np.bincount(place, values, len(keys))).without_zeros()


def pick(products, slots):
    """Row i is products[slots[i] - 1], or zeros."""
    check(len(slots) == 0 or slots.max() <= products.count, "index/slots: a product that does not exist")
    lengths = np.append(0, np.diff(products.offsets))[slots]
    elements = np.repeat(np.append(0, products.offsets[:-1])[slots], lengths) + ranges(lengths)
    return Sparse(np.append(0, np.cumsum(lengths)), products.columns[elements], products.values[elements], products.lights)
