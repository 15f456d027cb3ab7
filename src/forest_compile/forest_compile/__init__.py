"""How model functions become fast: ordinary Python is compiled to machine code.

In the order in which data passes:

- `entry`: The source of a kernel, and what its names mean.
- `flat_layout`: Nested tuples of numbers as flat rows of doubles, and back.
- `frontend`: Syntax trees of the functions that a kernel calls, inlined into one.
- `ir`: LLVM's intermediate representation as text.
- `machine_code`: From that text to machine code, and from there to a function of Python.
- `kernel_cache`: Machine code on disk, for the next process; `fingerprint` tells whether it is still the one,
  `kernel_files` whether it is the user's own.
- `compiled_step`: A compiled step behind the call of the interpreted one.

May import: nothing of ours.
"""
