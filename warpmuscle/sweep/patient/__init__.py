"""A patient's path: recorded strides, walks searched until they match them, and what a change of the body predicts.

`file` reads what is asked for, `recorded` the strides of recordings, `plan` writes the two sweeps that `path` runs, one
for walks like the patient's and one that goes on from them with each change, `compared` says how far walks are from the
patient's own strides, and `page` shows it.

May import: sweep and all below.
To add: a key of a patient's file to `file`; a quantity that walks are judged by to `compared.QUANTITIES`.
"""
