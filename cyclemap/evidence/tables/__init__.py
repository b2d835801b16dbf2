"""Tables of measured data, from files of any house to rows by our names.

`data_kinds` says what a file is. `own_files` and `text_tables` bring one of any format to columns
under its own names; `meaning` says which column is which and in what unit. `own_tables` puts these
together and makes pushes of rows, `pose_streams` of motions. `columns` has our names and our
convention of angles and axes, and reads tables that go by them; `planned_table` one that was filled
in.
"""
