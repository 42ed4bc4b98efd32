"""Reports of results: the facts as text (`summary`) and as one page that opens offline (`page`).

May import: plots, view and all below.
To add: a section to `summary` or to the page's template.
"""
