"""Do the 95 % intervals of `forest-ident` hold the truth? See interval_coverage.py, which does it.

python benchmarks/coverage.py [--sessions 200] [--only NAME ...] [--processes 2] [--json FILE]
"""

if __name__ != "__main__":
    # Numba looks for the package of this name, and would find this script beside the other benchmarks.
    raise ImportError("benchmarks/coverage.py is a script, not the package coverage")

from interval_coverage import main

main()
