"""Runs every notebook of this folder in the root of the checkout, and fails where one does; with ``--write``, keeps their outputs."""

from __future__ import annotations

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]

for path in sorted(HERE.glob("*.ipynb")):
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(ROOT)}}).execute()
    print(f"{path.name}: {sum(cell.cell_type == 'code' for cell in notebook.cells)} cells run")
    if "--write" in sys.argv:
        for cell in notebook.cells:
            # When a cell ran decides nothing.
            cell.metadata.pop("execution", None)
        nbformat.write(notebook, path)
