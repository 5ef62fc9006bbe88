"""Codecs that keep elements: dense, csr, compact, f16, runs, truncate."""

import numpy as np

from .container import check
from .rows import Sparse, dense, ranges

# How the forms of `compact` are stored.
FORMS = ["f4", "f2", "u1", "i1", "u2", "i2", "u1", "u2"]
WIDTHS = {1: "u1", 2: "u2", 4: "u4"}
BLOCK = 64


def read_dense(file, lights):
    return dense(file.take("weights/values", "f4", file.rows * lights).reshape(file.rows, lights))


def read_csr(file, lights):
    offsets = file.take("index/offsets", "u8", file.rows + 1)
    columns = file.take("index/columns", "u4", offsets[-1])
    return Sparse(offsets, columns, file.take("weights/values", "f4", offsets[-1]), lights)


def values_of(file, form, exponent, values, table, count):
    """Numbers in one of the forms of `compact`, as f64."""
    check(0 <= form < len(FORMS) and -149 <= exponent <= 127, f"form {form}, exponent {exponent}")
    stored = file.take(values, FORMS[form], count)
    if form < 6:
        check(form > 0 or exponent == 0, "an exponent of f32")
        return np.ldexp(stored.astype(float), exponent)
    table = file.take(table, "f4")
    check(exponent == 0 and len(table) <= 65536 and (count == 0 or stored.max() < len(table)), "codes beyond their table")
    return table[stored].astype(float)


def width(count):
    """Unsigned integers of so many bytes."""
    check(count in WIDTHS, f"numbers of {count} bytes")
    return WIDTHS[count]


def before(lengths):
    """The sum before each block of 64 lengths."""
    return (np.cumsum(lengths, dtype=np.int64) - lengths)[::BLOCK]


def read_compact(file, lights, rows=None, prefix=""):
    rows = file.rows if rows is None else rows
    form, exponent, *widths = file.take(f"header/{prefix}layout", "i4", 4).tolist()
    names = [f"weights/{prefix}values", f"weights/{prefix}table"]
    if widths == [0, 0]:
        return dense(values_of(file, form, exponent, *names, rows * lights).reshape(rows, lights))
    lengths = file.take(f"index/{prefix}lengths", width(widths[0]), rows)
    offsets = np.concatenate([[0], np.cumsum(lengths, dtype=np.int64)])
    starts = file.take(f"index/{prefix}starts", "u8", -(-rows // BLOCK))
    check((starts == before(lengths)).all(), "index/starts")
    columns = file.take(f"index/{prefix}columns", width(widths[1]), offsets[-1])
    return Sparse(offsets, columns, values_of(file, form, exponent, *names, offsets[-1]), lights)


def read_f16(file, lights):
    check(file.sections.get("header/layout", b"")[:4] == b"\1\0\0\0", "f16 of another form than 1")
    return read_compact(file, lights)


def read_runs(file, lights):
    alone = read_compact(file, lights)
    if not file.has("header/runs"):
        return alone
    form, exponent, *widths = file.take("header/runs", "i4", 5).tolist()
    blocks = file.take("index/run_blocks", "u8", 2 * -(-file.rows // BLOCK)).reshape(-1, 2).astype(np.int64)
    rows = file.take("index/run_rows", "u1").astype(np.int64)
    counts = file.take("index/run_counts", width(widths[0]), len(rows)).astype(np.int64)
    values = values_of(file, form, exponent, "weights/run_values", "weights/run_table", len(rows))
    starts = file.take("index/run_starts", width(widths[1]), counts.sum()).astype(np.int64)
    lengths = file.take("index/run_lengths", width(widths[2]), counts.sum()).astype(np.int64)
    pairs = np.diff(blocks[:, 0], append=len(rows))
    check(not blocks[:1].any() and (pairs >= 0).all(), "index/run_blocks")
    check((np.append(np.cumsum(counts) - counts, counts.sum())[blocks[:, 0]] == blocks[:, 1]).all(), "index/run_blocks")
    check((counts > 0).all() and (lengths > 0).all() and (rows < BLOCK).all(), "runs without columns")
    rows += BLOCK * np.repeat(np.arange(len(blocks)), pairs)
    rows, values = [np.repeat(np.repeat(each, counts), lengths) for each in (rows, values)]
    columns = np.repeat(starts, lengths) + ranges(lengths)
    rows, columns = [np.concatenate(both) for both in [(alone.rows(), rows), (alone.columns, columns)]]
    return Sparse.of_elements(file.rows, lights, rows, columns, np.concatenate([alone.values, values]))


def read_truncate(file, lights):
    order, bits = file.take("header/layout", "u1", 2).tolist()
    check(order <= 1 and bits in (8, 16, 32), f"order {order}, {bits} bits")
    column = "u1" if lights <= 256 else "u2" if lights <= 65536 else "u4"
    if order == 0:
        offsets = file.take("index/offsets", "u4", file.rows + 1).astype(np.int64)
        columns = file.take("index/columns", column, offsets[-1])
        rows = np.repeat(np.arange(file.rows), np.diff(offsets))
    else:
        blocks = file.take("index/blocks", "u4", 2 * (-(-file.rows // 1024) + 1)).reshape(-1, 2).astype(np.int64)
        columns = file.take("index/columns", column, blocks[-1, 0])
        lengths = file.take("index/lengths", "u2", blocks[-1, 0]).astype(np.int64)
        check((np.append(0, np.cumsum(lengths))[blocks[:, 0]] == blocks[:, 1]).all(), "index/blocks")
        check((lengths > 0).all(), "an empty column")
        columns = np.repeat(columns, lengths)
        rows = file.take("index/rows", "u2", blocks[-1, 1]) + 1024 * np.repeat(np.arange(len(blocks) - 1), np.diff(blocks[:, 1]))
    values = file.take("weights/values", {32: "f4", 16: "i2", 8: "i1"}[bits], len(columns)).astype(float)
    if bits < 32:
        values *= file.take("weights/steps", "f4", file.rows)[rows]
    return Sparse.of_elements(file.rows, lights, rows, columns, values)
