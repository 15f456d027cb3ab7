"""What makes IR of Python's syntax trees: integers, arithmetic, expressions, statements, then whole kernels.

May import: `ir`, `entry`, `fingerprint`, `flat_layout`.
"""
