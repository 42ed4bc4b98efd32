"""Runs of a sweep that are far behind others are stopped, so that the time goes to those that may win.

`rule` is what a sweep file says of it, and `referee` decides while runs go side by side.

May import: core, scene.
To add: another way to choose who goes on, in `referee.Referee`.
"""
