"""The container of docs/format.md: header, table of sections, checksums."""

import shutil
import struct
import subprocess
import zlib

import numpy as np

MAGIC = b"\x89PRT\r\n\x1a\n"


class Broken(ValueError):
    """Something is not what docs/format.md says, or not what it is compared with."""


def check(holds, message):
    if not holds:
        raise Broken(message)


def unzstd():
    """A function of compressed bytes and the length they unfold to, from whatever is there."""
    try:
        from compression import zstd  # Python 3.14

        return lambda data, length: zstd.decompress(data)
    except ImportError:
        pass
    try:
        import zstandard

        return lambda data, length: zstandard.ZstdDecompressor().decompress(data, max_output_size=length)
    except ImportError:
        pass
    try:
        import pyzstd

        return lambda data, length: pyzstd.decompress(data)
    except ImportError:
        pass
    if shutil.which("zstd"):
        return lambda data, length: subprocess.run(["zstd", "-dcq"], input=data, capture_output=True, check=True).stdout
    raise SystemExit("decode.py: no zstd: install the package zstandard (pip install zstandard) or the command zstd")


class File:
    """A file's header as attributes, its sections as arrays; `take` each once, then `finish`."""

    def __init__(self, path):
        with open(path, "rb") as file:
            self.data = file.read()
        try:
            self._read()
        except (struct.error, UnicodeDecodeError) as error:
            raise Broken(f"the header ends early or holds no text: {error}") from error
        self.taken = set()
        # What relighting holds: the sections; codecs and transforms add what they derive. None where it does not follow.
        self.resident = sum(map(len, self.sections.values()))

    def _read(self):
        data, self.at = self.data, 8
        check(data[:8] == MAGIC, "not a .prt file")
        version, length = self._numbers("II")
        end = 16 + length
        check(version in (1, 2), f"version {version} of the container, expected 1 or 2")
        check(20 <= end <= len(data), "the header is longer than the file")
        crc = struct.unpack_from("<I", data, end - 4)[0]
        check(zlib.crc32(data[: end - 4]) == crc, "the header's checksum does not match")
        self.label, self.tag = self._text("H"), self._text("H")
        self.samples, self.responses, self.lights = self._numbers("QQQ")
        self.basis = self._text("H")
        self.response_basis = self._text("H") if version == 2 else f"plain:{self.responses}"
        self.layout, count = self._numbers("BH")
        check(self.layout <= 2 and self.responses >= 1 and self.lights <= 1 << 25 and count <= 256, "a shape out of bounds")
        check(lights_of(self.basis) == self.lights, f"{self.basis} with {self.lights} lights")
        self.rows = self.samples * self.responses
        entries = [(self._text("B"), *self._numbers("BQQI")) for _ in range(count)]
        check(self.at == end - 4, "the header has another length than it says")
        check(len({entry[0] for entry in entries}) == count, "two sections of one name")
        self.sections = {}
        for name, encoding, raw, stored, crc in entries:
            payload = data[end : end + stored]
            check(len(payload) == stored, f"the file ends within {name}")
            self.sections[name] = self._unfold(name, payload, encoding, raw, crc)
            end += stored
        check(end == len(data), "bytes after the last section")

    def _unfold(self, name, payload, encoding, raw, crc):
        check(encoding in (0, 1), f"{name}: encoding {encoding}")
        limit = 1000 * len(payload) + 65536 if encoding else len(payload)
        check(raw <= limit and (encoding or raw == limit), f"{name}: {len(payload)} stored bytes cannot hold {raw}")
        if encoding:
            try:
                payload = unzstd()(payload, raw)
            except Exception as error:  # each module has errors of its own
                raise Broken(f"{name}: zstd: {error}") from error
        check(len(payload) == raw and zlib.crc32(payload) == crc, f"{name}: length or checksum does not match")
        return payload

    def _numbers(self, form):
        values = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return values

    def _text(self, form):
        length = self._numbers(form)[0]
        return self._numbers(f"{length}s")[0].decode()

    def has(self, name):
        return name in self.sections

    def take(self, name, form, count=None):
        """Section `name` as numbers of NumPy's type `form`, `count` of them, or as many as there are. Floats must be finite."""
        check(name in self.sections, f"no section {name}")
        data = self.sections[name]
        form = np.dtype(form).newbyteorder("<")
        expected = len(data) // form.itemsize if count is None else int(count)
        check(len(data) == expected * form.itemsize, f"{name}: {len(data)} bytes, expected {expected} x {form.itemsize}")
        self.taken.add(name)
        numbers = np.frombuffer(data, form)
        check(form.kind != "f" or np.isfinite(numbers).all(), f"{name}: a number that is not finite")
        return numbers

    def finish(self):
        check(self.taken == set(self.sections), f"sections of another codec: {set(self.sections) - self.taken}")


def lights_of(basis):
    """The number of lights of a light basis."""
    kind, *rest = basis.split(":")
    size = rest[0] if rest else ""
    if kind == "latlong":
        width, height = map(int, size.split("x"))
        return width * height
    check(kind in ("plain", "lobes", "cubemap", "sh") and size.isdigit(), f"light basis {basis}")
    return {"cubemap": 6 * int(size) ** 2, "sh": int(size) ** 2}.get(kind, int(size))


def method(label):
    """(transform, its parameters), (codec, its parameters) of a label."""

    def part(text):
        name, *pairs = text.split(":")
        return name, dict(pair.split("=", 1) for pair in pairs)

    parts = label.split("+")
    check(len(parts) <= 2, f"label {label}")
    return part(parts[0]) if len(parts) == 2 else ("identity", {}), part(parts[-1])
