"""Reflexes that states of gait switch on and off, a leg at a time: what a scene says, and its checks.

May import: core, scene.number, scene.part, scene.joints, scene.validation.checks.
To add: a signal to `part.GaitReflex` and `kernels.gait_state_structs`, its place in `model.controllers.gait_states`,
what it senses in `kernels.control.gait_sensors`.
"""
