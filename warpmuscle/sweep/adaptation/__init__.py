"""How people adapt their walking to speed, slope and load, as measured, beside what searches predict.

`records` reads what was measured, `plan` makes a sweep of it, `predicted` measures its gaits, `compared` holds changes
against changes, `page` shows them.

May import: sweep and all below.
To add: a place of a load to `plan.PLACES`, a formula of metabolic power to `predicted.FORMULAS`.
"""
