"""What `prt bench` says of a file, computed anew: errors against the matrix, sizes."""

import numpy as np

from . import sphere
from .codecs import rows_of
from .container import File, check, method
from .rows import Sparse

# Numbers of a block of rows: 8 MB, which caches like.
BLOCK = 1 << 20


class Metric:
    """In which a squared error is one of radiance (docs/format.md, "Errors")."""

    def __init__(self, basis, response_basis):
        kind, *rest = response_basis.split(":")
        texels = sphere.is_texels(basis)
        self.known = texels or basis.startswith("sh:") or basis.endswith(":orthonormal")
        self.angles = sphere.solid_angles(basis) if texels else None
        # Elements of visibility and of light fields leave the solid angle to the light.
        self.light_has_angle = texels and kind in ("local", "texels")
        self.weights = None if not texels else self.angles if self.light_has_angle else 1 / self.angles
        self.mix = np.linalg.cholesky(sphere.exit_gram(int(rest[0]))).T if kind == "exit" else None

    def mixed(self, rows, responses):
        """Rows of whole samples in coordinates in which squares add up to radiance's."""
        return rows if self.mix is None else (self.mix @ rows.reshape(-1, responses, rows.shape[1])).reshape(rows.shape)

    def weighted(self, squares):
        """Of Σ of squares by column."""
        return float(squares.sum() if self.weights is None else squares @ self.weights)

    def light(self, light):
        """A light of radiance as the matrix wants it."""
        return light * self.angles[:, None] if self.light_has_angle else light


class Sums:
    """Of a matrix or a difference: Σ d², the same over the sphere, max |d|, numbers d that are not 0, and Σ of relit squares under each light."""

    def __init__(self, metric, responses, lights):
        self.metric, self.responses, self.lights = metric, responses, lights
        self.squares = self.weighted = self.max = 0.0
        self.non_zeros = 0
        self.relit = dict.fromkeys(lights, 0.0)

    def add(self, rows):
        """Rows of whole samples."""
        metric, squares = self.metric, np.square(rows)
        columns = squares.sum(0)
        self.non_zeros += int(np.count_nonzero(rows))
        self.squares += float(columns.sum())
        self.max = max(self.max, float(squares.max(initial=0)) ** 0.5)
        if metric.mix is not None:
            columns = np.square(metric.mixed(rows, self.responses)).sum(0)
        self.weighted += metric.weighted(columns)
        for name, light in self.lights.items():
            self.relit[name] += float(np.square(metric.mixed(rows @ light, self.responses)).sum())

    def add_sparse(self, rows):
        """A whole matrix whose rows the metric does not mix."""
        columns = np.bincount(rows.columns, rows.values**2, rows.lights)
        self.non_zeros += len(rows.values)
        self.squares += float(columns.sum())
        self.max = max(self.max, float(np.abs(rows.values).max(initial=0)))
        self.weighted += self.metric.weighted(columns)
        of_rows = rows.rows()
        for name, light in self.lights.items():
            for channel in light.T:
                self.relit[name] += float(np.square(np.bincount(of_rows, rows.values * channel[rows.columns])).sum())


def difference(a, b):
    """a - b of two sparse matrices."""
    keys = np.concatenate([a.keys(), b.keys()])
    order = np.argsort(keys, kind="stable")
    keys, values = keys[order], np.concatenate([a.values, -b.values])[order]
    first = np.flatnonzero(np.diff(keys, prepend=-1))
    values = np.add.reduceat(values, first) if len(first) else values
    return Sparse.of_keys(a.count, a.lights, keys[first], values).without_zeros()


def sums_of(metric, responses, lights, matrix, other=None):
    """Those of `matrix`, or of how it differs from `other`."""
    sums = Sums(metric, responses, lights)
    if metric.mix is None and isinstance(matrix, Sparse) and (other is None or isinstance(other, Sparse)):
        sums.add_sparse(matrix if other is None else difference(matrix, other))
        return sums
    step = max(1, BLOCK // max(1, responses * matrix.lights)) * responses
    for begin in range(0, matrix.count, step):
        end = min(begin + step, matrix.count)
        block = matrix.block(begin, end)
        sums.add(block if other is None else block - other.block(begin, end))
    return sums


def relative(error, whole):
    """An error where there is nothing to be relative to is infinite, which JSON does not know; nor does it know numbers that are none."""
    check(np.isfinite(error), "what the file stands for is not finite")
    check(error == 0 or whole > 0, "the matrix is 0, what the file stands for is not")
    return error / whole if error else 0.0


class Reference:
    """A matrix, and its sums in each metric that was asked for."""

    def __init__(self, matrix):
        self.matrix, self.sums = matrix, {}

    def whole(self, metric, file, lights):
        key = (file.basis, file.response_basis, tuple(lights))
        if key not in self.sums:
            self.sums[key] = sums_of(metric, file.responses, lights, self.matrix)
        return self.sums[key]


def figures(path, reference=None, lights={}):
    """Of a file, and against a matrix: one object for JSON. `lights` are radiance by name, lights x channels."""
    file = File(path)
    rows = rows_of(file)
    found = {
        "label": file.label,
        "codec": file.tag,
        "samples": file.samples,
        "responses": file.responses,
        "lights": file.lights,
        "file_bytes": len(file.data),
        "resident_bytes": int(file.resident),
    }
    if reference is None:
        return found
    shape = (reference.matrix.count, reference.matrix.lights)
    check(shape == (file.rows, file.lights), f"a matrix of {shape[0]} x {shape[1]}, the file's is {file.rows} x {file.lights}")
    metric = Metric(file.basis, file.response_basis)
    # With light_terms relighting is no product with what is decoded.
    lights = {} if "light_terms" in method(file.label)[0][1] else {name: metric.light(light) for name, light in lights.items()}
    whole = reference.whole(metric, file, lights)
    error = sums_of(metric, file.responses, lights, reference.matrix, rows)
    found |= {"non_zeros": whole.non_zeros, "matrix_max": whole.max, "error": relative(error.squares, whole.squares), "error_max": error.max}
    found["error_sphere"] = relative(error.weighted, whole.weighted) if metric.known else None
    found["relit"] = {name: relative(error.relit[name], whole.relit[name]) for name in lights}
    return found
