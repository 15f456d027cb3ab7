"""LLVM's intermediate representation (IR) as text: values, then functions of blocks, then the module of all.

May import: nothing of ours.
"""
