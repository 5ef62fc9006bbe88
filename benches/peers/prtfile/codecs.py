"""A file's rows, whatever its codec and transform."""

from .bicluster import read_bicluster
from .clusters import read_cpca, read_cta, read_slf
from .container import check, method
from .elements import read_compact, read_csr, read_dense, read_f16, read_runs, read_truncate
from .rows import Lazy
from .transforms import restore
from .visibility import read_visibility

CODECS = {
    "dense.1": read_dense,
    "csr.1": read_csr,
    "compact.1": read_compact,
    "runs.1": read_runs,
    "visibility.1": read_visibility,
    "f16.1": read_f16,
    "truncate.1": read_truncate,
    "cpca.1": read_cpca,
    "cta.1": read_cta,
    "slf.1": read_slf,
    "bicluster.1": read_bicluster,
}


def rows_of(file):
    """The matrix that `file` stands for, by rows."""
    check(file.tag in CODECS, f"codec {file.tag}, known are {', '.join(CODECS)}")
    coefficients, back = restore(file, *method(file.label)[0])
    rows = CODECS[file.tag](file, coefficients)
    file.finish()
    if back is None:
        return rows
    return Lazy(rows.count, file.lights, lambda begin, end: back(rows.block(begin, end)))
