"""A window to work in: a page in the browser over a project, served on this computer only (`serve.py`)."""
