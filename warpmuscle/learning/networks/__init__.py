"""What learns, in PyTorch: policy and critic, their mirror images, and proximal policy optimisation of both.

May import: learning.
To add: a network to `actor_critic`; another way to improve one to a file like `ppo`.
"""
