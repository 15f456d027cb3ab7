"""A bag as it grows: files, splits, what each file begins with."""
