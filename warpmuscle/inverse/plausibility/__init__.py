"""What of a recording cannot well be: each finding is a note of one line that says what follows from it.

`motions` looks at times and coordinates, `ground_forces` at forces on bodies; `inverse.dynamics` asks both.

May import: core.
To add: a function that gives notes, in the file of what it looks at.
"""
