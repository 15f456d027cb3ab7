"""The thesis's estimators (chapter 4), one parameter or a few at a time.

`parameter_estimate` has the result of each: value, standard error and 95 % confidence interval.
"""
