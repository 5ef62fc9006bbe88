"""Matrices and labels that together reach every branch of docs/format.md, and which branches a file takes."""

import json
import subprocess

import numpy as np

ELEMENTS = """dense csr compact runs visibility f16 bicluster bicluster:levels=1 bicluster:levels=2 bicluster:objective=flops bicluster:max_error=0.05
    truncate:terms=5 truncate:terms=5:bits=16 truncate:terms=5:bits=8 truncate:terms=300 truncate:energy=0.9:order=columns
    truncate:terms=4:order=columns:bits=16 truncate:terms=4:order=columns:bits=8""".split()
CLUSTERS = """vq:clusters=7 vq:clusters=5:representatives=f16 vq:clusters=5:representatives=i16 pca pca:components=0 pca:weights=f16:representatives=i16
    cpca:clusters=5 cpca:clusters=1:components=2 cpca:clusters=6:components=3:mode=adaptive cpca:clusters=9:norm=radiance:components=3
    cpca:clusters=6:components=3:mode=adaptive:weights=i16:representatives=f16 cpca:clusters=5:components=2:weights=i16:representatives=i16
    cpca:clusters=auto:max_error=0.01 tucker:view=2:light=5:sample=6 tucker:view=2:light=5:sample=6:numbers=f32 tucker:view=2:light=5:sample=6:numbers=f16
    tucker:view=2:light=5:sample=6:numbers=coded tucker:max_error=0.01 cta:clusters=5:view=2:light=4:sample=3 cta:clusters=5:view=2:light=4:sample=3:numbers=f32
    cta:clusters=5:view=2:light=4:sample=3:numbers=f16 cta:clusters=5:view=2:light=4:sample=3:numbers=coded cta:clusters=5:members=2
    cta:clusters=5:members=3:numbers=coded cta:clusters=30:light=9:sample=9""".split()
FIELDS = [
    f"slf:clusters=4:components=2{colour}{widths}"
    for colour in ("", ":colour=separate", ":colour=joint")
    for widths in ("", ":surface=f16:views=i16", ":surface=i16:views=f16", ":maps=haar")
] + ["slf:clusters=1:components=0", "slf:clusters=auto:max_error=0.01", "slf:clusters=4:components=2:maps=haar:noise=0.5"]
TRANSFORMS = """haar+csr haar+compact haar+bicluster haar:scale=sphere+truncate:terms=9 haar+truncate:terms=9:bits=8 haar:light_terms=5+dense
    haar:scale=sphere+cpca:clusters=4 sh+dense sh:order=1+dense sh:order=7+f16 sh:order=3+cpca:clusters=4 srbf:centers=42+dense srbf:centers=12+csr
    srbf:centers=162+f16 srbf:centers=42:kernel=abel-poisson+dense srbf:centers=42:bandwidth=20:coordinates=lobes+dense
    srbf:centers=162:bandwidth=3+dense srbf:centers=42:bandwidth=3:ridge=1e-4+dense srbf:centers=42:ridge=0+dense
    srbf:centers=42:kernel=abel-poisson:bandwidth=0.9:coordinates=lobes+cpca:clusters=3 srbf:centers=42+cta:clusters=3 srbf+dense
    srbf:centers=42:kernel=abel-poisson:bandwidth=0.2+dense""".split()
LABELS = ELEMENTS + CLUSTERS + FIELDS + TRANSFORMS
# Matrices that say what they are, and labels by which their errors are compared with those of `prt bench`.
FIGURES = {
    "biscale": ["visibility", "bicluster", "haar+truncate:terms=9", "sh:order=3+dense"],
    "diffuse": ["runs", "f16", "haar:scale=sphere+truncate:terms=9", "cpca:clusters=5", "srbf:centers=42+cta:clusters=3"],
    "diffuse-harmonics": ["cpca:clusters=5:components=2"],
    "glossy": ["f16", "cpca:clusters=5", "tucker:view=4:light=9:sample=9"],
    "glossy-8": ["cpca:clusters=5"],
    "glossy-orthonormal": ["cpca:clusters=5"],
    "terms": ["cta:clusters=5", "sh+dense"],
    "described-latlong": ["pca:components=3"],
    "described-field": ["slf:clusters=4:components=2", "pca:components=3"],
}
# Of files of these labels and matrices every damage must be noticed.
DAMAGED = {
    "csr": "bytes",
    "haar+truncate:terms=9:bits=8": "diffuse",
    "bicluster": "biscale",
    "cta:clusters=5": "samples",
    "slf:clusters=4:components=2:maps=haar": "field",
}
SECTIONS = """header/runs weights/run_table weights/table index/arities header/products index/superclusters header/maps basis/view header/srbf-ridge
    basis/srbf-centers""".split()
# What some file must have had.
BRANCHES = [
    *("bicluster compact cpca csr cta dense f16 runs slf truncate visibility".split()),
    *[f"version {n}" for n in (1, 2)],
    *[f"layout {n}" for n in (0, 1, 2)],
    *[f"form {n}" for n in range(8)],
    *[f"{kind} {n}" for kind in ("lengths", "columns") for n in (0, 1, 2, 4)],
    *[f"truncate order {order} bits {bits}" for order in (0, 1) for bits in (8, 16, 32)],
    *[f"{kind} {n}" for kind in ("cpca basis", "cpca weights", "cta width", "slf colour", "slf surface", "slf views") for n in (0, 1, 2)],
    *[f"{codec} unequal {unequal}" for codec in ("cpca", "cta") for unequal in (False, True)],
    *[f"cta members {n}" for n in (1, 2)],
    *[f"slf map {bit} haar {haar}" for bit in (1, 2, 4) for haar in (False, True)],
    *[f"bicluster {form}" for form in ("plain", "slots", "pairs")],
    *[f"listing {together}" for together in (False, True)],
    *[f"bicluster {there} {name}" for there in ("with", "without") for name in ("index/arities", "header/products")],
    *[f"runs {there} {name}" for there in ("with", "without") for name in ("header/runs", "weights/run_table", "weights/table")],
    *[f"{there}" for there in ("cta with basis/view", "cta without basis/view", "cpca with index/superclusters", "slf with header/maps")],
    *[f"dense with {name}" for name in ("header/srbf-ridge", "basis/srbf-centers")],
]


class Matrices:
    """Files of small matrices, with what `prt encode` has to be told of them."""

    def __init__(self, folder, prt):
        self.folder, self.prt, self.files = folder, prt, {}
        self.random = np.random.default_rng(1)
        self.sparse_forms()
        self.smooth_ones()
        self.scenes()

    def npz(self, name, matrix, *told, **note):
        rows, columns = np.nonzero(matrix)
        offsets = np.searchsorted(rows, np.arange(len(matrix) + 1)).astype(np.int32)
        arrays = {"data": matrix[rows, columns], "indices": columns.astype(np.int32), "indptr": offsets}
        if note:
            arrays["prt"] = np.frombuffer(json.dumps(note).encode(), np.uint8)
        path = f"{self.folder}/{name}.npz"
        np.savez(path, format=np.array(b"csr"), shape=np.array(matrix.shape), **arrays)
        self.files[name] = (path, told)

    def npy(self, name, matrix, *told):
        np.save(f"{self.folder}/{name}.npy", matrix)
        self.files[name] = (f"{self.folder}/{name}.npy", told)

    def sparse(self, rows, lights, values, density):
        chosen = self.random.random((rows, lights)) < density
        return np.where(chosen, self.random.choice(values, (rows, lights)), 0).astype(np.float32)

    def sparse_forms(self):
        normal = self.random.normal
        self.npz("bytes", self.sparse(130, 70, np.arange(-90, 90), 0.2), "--basis", "plain:70")
        self.npz("quarters", self.sparse(130, 300, np.arange(1, 200) / 4, 0.1), "--responses", "2")
        self.npz("words", self.sparse(70, 70, np.arange(1, 40000) * 2.0, 0.4))
        self.npz("signed-words", self.sparse(70, 70, np.arange(-20000, 20000) / 2, 0.4))
        self.npz("halves", self.sparse(70, 70, normal(size=3000).astype(np.float16), 0.4))
        self.npz("few-values", self.sparse(130, 70, normal(size=200), 0.3))
        self.npz("many-values", self.sparse(400, 200, normal(size=2000), 0.3))
        self.npz("floats", self.sparse(130, 70, normal(size=20000), 0.2))
        self.npz("wide", self.sparse(6, 70000, [1.0], 0.01))
        long = np.zeros((20, 70000), np.float32)
        long[3, 1000:67000] = 1
        self.npz("long-row", long)
        self.npz("zeros", np.zeros((10, 20), np.float32))
        self.npz("one", np.ones((1, 1), np.float32))
        self.npz("no-rows", np.zeros((0, 5), np.float32))
        self.npz("integers", self.sparse(30, 40, np.arange(1, 9), 0.3).astype(np.int64))
        self.npz("runs", np.repeat(self.sparse(200, 40, [0.25, 0.5, 1], 0.3), 9, axis=1))
        self.npz("runs-of-many-values", np.repeat(self.sparse(300, 20, normal(size=900), 0.3), 9, axis=1))
        self.npz("long-runs", np.repeat(self.sparse(100, 4, [0.25, 0.5, 1], 0.5), 600, axis=1))
        shared = np.repeat(self.sparse(20, 40, [0.25, 0.5, 1, 3], 0.3), 20, axis=0)[self.random.permutation(400)]
        self.npz("shared", shared * (self.random.random(shared.shape) < 0.95))

    def smooth_ones(self):
        def smooth(rows, lights):
            u, s, v = np.linalg.svd(self.random.normal(size=(rows, lights)), full_matrices=False)
            return ((u * 0.8 ** np.arange(len(s))) @ v).astype(np.float32)

        self.npy("smooth", smooth(200, 60))
        self.npy("whole-blocks", smooth(128, 60))
        self.npy("samples", smooth(100, 180).reshape(100, 3, 60))
        self.npy("lobes", smooth(40, 42), "--basis", "lobes:42")
        self.npy("cubemap", smooth(150, 96 * 4).reshape(150, 4, 96), "--basis", "cubemap:4")
        self.npy("latlong", smooth(120, 16 * 8), "--basis", "latlong:16x8")
        self.npy("tiny-cubemap", smooth(50, 6), "--basis", "cubemap:1")
        self.npz("described-latlong", smooth(40, 32), responses=1, response_basis="irradiance", basis="latlong:8x4")
        self.npz("described-field", smooth(90, 32), responses=3, response_basis="texels:6x5:wrap", basis="latlong:8x4")
        for name, x, y in [("field", 10, 9), ("odd-field", 7, 13)]:
            told = ["--responses", f"texels:{x}x{y}", "--basis", "latlong:9x5"]
            self.npy(name, smooth(x * y, 3 * 45).reshape(x * y, 3, 45), *told)

    def scenes(self):
        for name, line in {
            "biscale": "blob --signal biscale --basis cubemap:8 --vertices 60",
            "biscale-chair": "chair --signal biscale --basis cubemap:16 --vertices 40 --supersampling 2 --local-directions 3",
            "biscale-coarse": "teapot --signal biscale --basis cubemap:4 --vertices 100 --local-directions 4",
            "diffuse": "teapot --signal diffuse --basis cubemap:8 --vertices 100",
            "diffuse-harmonics": "teapot --signal diffuse --basis sh:5 --vertices 100",
            "glossy": "teapot --signal glossy --vertices 80",
            "glossy-8": "teapot --signal glossy --coefficients 8 --vertices 80",
            "glossy-orthonormal": "teapot --signal glossy --orthonormal --coefficients 16 --vertices 80",
            "terms": "teapot --signal terms --terms 4 --basis cubemap:8 --vertices 80",
        }.items():
            self.files[name] = (f"{self.folder}/{name}.npz", ())
            run(self.prt, "precompute", *line.split(), "-o", f"{self.folder}/{name}.npz")


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout


def branches(file):
    """Which branches of docs/format.md a file takes, as far as someone could forget to read them."""
    name = file.tag.split(".")[0]
    numbers = lambda section, form="<u4": np.frombuffer(file.sections.get(section, b""), form).tolist()
    found = {name, f"layout {file.layout}", f"version {1 if file.response_basis.startswith('plain:') else 2}"}
    found |= {f"{name} {'with' if section in file.sections else 'without'} {section}" for section in SECTIONS}
    layout = numbers("header/layout", "u1" if name == "truncate" else "<u4")
    if name in ("compact", "f16"):
        found |= {f"form {layout[0]}", f"lengths {layout[2]}", f"columns {layout[3]}"}
    if name == "truncate":
        found |= {f"truncate order {layout[0]} bits {layout[1]}"}
    if name == "cpca":
        unequal = len(numbers("index/components")) > 1
        found |= {f"cpca basis {layout[1]}", f"cpca weights {layout[2]}", f"cpca unequal {unequal}"}
    if name == "cta":
        unequal = len(numbers("index/ranks")) > 2
        found |= {f"cta width {layout[3]}", f"cta members {min(2, layout[1])}", f"cta unequal {unequal}"}
    if name == "slf":
        found |= {f"slf colour {layout[0]}", f"slf surface {layout[2]}", f"slf views {layout[3]}"}
        found |= {f"slf map {bit} haar {flags & bit > 0}" for flags in numbers("header/maps")[4:] for bit in (1, 2, 4)}
    if name == "bicluster":
        form = [part for part in ("slots", "pairs") if f"index/{part}" in file.sections]
        found |= {f"bicluster {''.join(form) or 'plain'}", f"listing {numbers('header/listing')[:1] > [1]}"}
    return found
