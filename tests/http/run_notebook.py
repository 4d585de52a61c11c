#!/usr/bin/env python3
"""Runs the code cells of a notebook in order, as a script: run_notebook.py FILE.ipynb. A cell that
raises is shown and ends it."""

import json
import os
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
path = pathlib.Path(sys.argv[1]).resolve()
os.chdir(path.parent)
names = {"__name__": "__main__"}
cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
for number, cell in enumerate(cells):
    if cell["cell_type"] == "code":
        source = "".join(cell["source"])
        exec(compile(source, f"{path.name}, cell {number}", "exec"), names)
drawn = matplotlib.pyplot.get_fignums()
print(f"{path.name}: {len(cells)} cells, {len(drawn)} pictures")
sys.exit(0 if drawn else f"{path.name} draws nothing")
