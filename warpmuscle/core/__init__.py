"""What everything else stands on: errors, arguments, arrays, files, quaternions. It knows nothing of scenes or muscles.

May import: kernels.
To add: what two packages need that know nothing of each other, in a module named after what it does.
"""
