"""Executes a notebook in the present directory. Argument: the notebook."""

import sys

import nbformat
from nbclient import NotebookClient

notebook = nbformat.read(sys.argv[1], as_version=4)
assert all(not cell.outputs for cell in notebook.cells if cell.cell_type == "code"), "committed with outputs: clear them"
NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": "."}}).execute()
