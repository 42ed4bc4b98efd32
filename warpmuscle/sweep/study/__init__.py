"""Studies: what the runs of a sweep under several conditions show, measured, compared, and as a page.

May import: sweep and all below.
To add: a key of `[study]` in `table.Study`; what is compared in `measured`, how it is shown in `page`.
"""
