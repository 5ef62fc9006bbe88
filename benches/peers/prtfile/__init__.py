"""Reads .prt files as docs/format.md describes them, with NumPy alone."""
