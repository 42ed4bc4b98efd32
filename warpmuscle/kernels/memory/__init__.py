"""Where an instance's working set lies, and what tells a compiler so.

May import: kernels.

To add: a row of the working set to `scratch`, with from when to when it lives.
"""
