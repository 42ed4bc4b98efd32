"""Muscle synergies: signals and matrices of numbers, no bipeds. See the modules, each of one topic."""
