"""One implicit stage of the plant: hoses solved exactly, joint rates and what is beside them by Newton."""
