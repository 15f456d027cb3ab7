"""How laws become fast: ordinary Python is translated to machine code, which is kept for the next process.

May import: nothing of ours.
"""
