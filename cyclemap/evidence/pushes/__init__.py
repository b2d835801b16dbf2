"""Measured pushes as one table.

`push_files` (with `recordings`) reads the MIT layout; `push_table` gathers pushes
of files and tables as a row each, `theta0_pairs` orientations alone; `measured_strokes` and
`contact_forces` are what an identification takes of them.
"""
