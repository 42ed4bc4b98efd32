"""Bones of a figure: which bodies are limbs (`limbs`), and bones of people (`skeleton`) as triangles (`meshes`).

May import: view and all below.
To add: a bone to `skeleton`, and where it is to be to `view.figure`.
"""
