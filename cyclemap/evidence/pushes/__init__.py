"""Measured pushes, from files of any kind to one table.

`columns` says what a column is called, what it holds and in which units; `conventions` how angles
are counted and axes laid. Who reads a file brings it to both: `push_files` (with `mit_names`) the
MIT layout; `own_files` the columns of a spreadsheet, a bag or any CSV, `own_tables` what they mean,
`pose_streams` a moving object's; `planned_table` a table that was filled in. `push_table` gathers
pushes as a row each, `theta0_pairs` orientations alone, `measured_strokes` and `contact_forces`
what an identification takes of them.
"""
