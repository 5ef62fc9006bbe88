"""Matrices by rows: sparse ones, and ones that are made block by block; those that `prt bench` keeps."""

import os

import numpy as np

from .container import check


class Lazy:
    """`count` rows of `lights` numbers; `block(begin, end)` makes some of them. Ends must be those of samples."""

    def __init__(self, count, lights, block):
        self.count, self.lights, self.block = count, lights, block


def dense(values):
    """Rows that are there."""
    return Lazy(*values.shape, lambda begin, end: np.asarray(values[begin:end], float))


class Sparse:
    """Elements by rows, columns strictly ascending in each."""

    def __init__(self, offsets, columns, values, lights):
        self.offsets, self.columns, self.lights = offsets.astype(np.int64), columns.astype(np.int64), lights
        self.values, self.count = values.astype(float), len(offsets) - 1
        n = len(columns)
        check(self.offsets[0] == 0 and self.offsets[-1] == n == len(values) and (np.diff(self.offsets) >= 0).all(), "offsets of rows")
        check(n == 0 or (self.columns.min() >= 0 and self.columns.max() < lights), "a column beyond the lights")
        check((np.diff(self.keys()) > 0).all(), "columns of a row that do not ascend")

    @staticmethod
    def of_elements(count, lights, rows, columns, values):
        """From elements in any order."""
        columns = columns.astype(np.int64)
        check(len(columns) == 0 or (columns.max() < lights and rows.max() < count), "an element outside of the matrix")
        keys = rows * np.int64(lights) + columns
        order = np.argsort(keys, kind="stable")
        return Sparse.of_keys(count, lights, keys[order], values[order])

    @staticmethod
    def of_keys(count, lights, keys, values):
        """From row · lights + column, ascending."""
        offsets = np.searchsorted(keys, np.arange(count + 1) * lights)
        return Sparse(offsets, keys % max(lights, 1), values, lights)

    def rows(self):
        """The row of each element."""
        return np.repeat(np.arange(self.count), np.diff(self.offsets))

    def keys(self):
        """row · lights + column of each element."""
        return self.rows() * self.lights + self.columns

    def block(self, begin, end):
        first, last = self.offsets[begin], self.offsets[end]
        out = np.zeros((end - begin, self.lights))
        rows = np.repeat(np.arange(end - begin), np.diff(self.offsets[begin : end + 1]))
        out[rows, self.columns[first:last]] = self.values[first:last]
        return out

    def without_zeros(self):
        keep = self.values != 0
        return Sparse.of_keys(self.count, self.lights, self.keys()[keep], self.values[keep])


def ranges(lengths):
    """0 .. n - 1 for each n of `lengths`, one after the other."""
    ends = np.cumsum(lengths)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - lengths, lengths)


def read_matrix(path):
    """A .npy, rows x lights or samples x responses x lights, or scipy.sparse's .npz; numbers at their value as f32."""
    extension = os.path.splitext(path)[1].lower()
    check(extension in (".npy", ".npz"), f"{path}: a matrix is a .npy or .npz")
    if extension == ".npy":
        values = np.load(path, mmap_mode="r")
        check(values.ndim in (2, 3), f"{path}: {values.ndim} dimensions, expected 2 or 3")
        return dense(values.reshape(-1, values.shape[-1]))
    with np.load(path) as file:
        form, (count, lights) = file["format"].item(), file["shape"].tolist()
        check(form in (b"csr", b"csc", b"coo"), f"{path}: format {form}, expected csr, csc or coo")
        if form == b"coo":
            rows, columns = file["row"], file["col"]
        else:
            along = np.repeat(np.arange(len(file["indptr"]) - 1), np.diff(file["indptr"]))
            rows, columns = (along, file["indices"]) if form == b"csr" else (file["indices"], along)
        return Sparse.of_elements(count, lights, rows, columns, file["data"].astype(np.float32)).without_zeros()
