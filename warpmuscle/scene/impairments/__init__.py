"""Impairments of muscles: what a scene says of them (`part`), and muscles that have them (`impaired`).

May import: core, scene.
To add: a factor to `Impairment`, which has the name of the number of a muscle that it multiplies; its check, if it
needs one, to `scene.validation.impairments`.
"""
