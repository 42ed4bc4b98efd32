"""Reflexes that states of gait switch on and off, a leg at a time: what a scene says, and its checks.

May import: core, scene.number, scene.part, scene.joints, scene.validation.checks.
To add: a signal to `part.GaitReflex` and `kernels.gait_state_structs`, its place in `model.gait_states`.
"""
