"""Published numbers of people who walk and run, by who measured them; `scene.norms` makes norms of them.

May import: core.
To add: a file with the name of the study, with its source and its licence.
"""
