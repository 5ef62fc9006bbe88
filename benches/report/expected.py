"""What a report.html should show, worked out from the data in it without a browser."""

import json
import re

# Errors of exact methods below this are the rounding of their sums.
ROUNDING = 1e-12


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


class Data:
    """What the file says, read without a browser."""

    def __init__(self, path):
        text = path.read_text(encoding="utf-8")
        found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
        self.data = json.loads(found.group(1))
        self.groups = self.data["groups"]
        self.quantities = {q["key"]: q for q in self.data["quantities"]}
        self.axes = [key for key, q in self.quantities.items() if q["role"] in ("error", "cost")]

    def value(self, row, key):
        value = row.get(key)
        if row["status"] != "ok" or not is_number(value) or value < 0:
            return None
        exact = row["error"] == 0 and self.quantities[key]["role"] == "error" and value < ROUNDING
        return 0.0 if exact else value

    def points(self, group, up, across, keep=lambda row: True):
        """Places by the row's number."""
        placed = ((i, self.value(r, across), self.value(r, up)) for i, r in enumerate(group["rows"]) if keep(r))
        return {i: (x, y) for i, x, y in placed if x is not None and y is not None}


def frontier(points):
    """By the definition: nothing is at least as good in both and better in one; of equals the first."""
    def beaten(i, p):
        return any((q[0] <= p[0] and q[1] <= p[1]) and (q != p or j < i) for j, q in points.items() if j != i)

    return {i for i, p in points.items() if not beaten(i, p)}
