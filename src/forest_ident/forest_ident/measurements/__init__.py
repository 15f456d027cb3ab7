"""A record as estimators take it: readings on one time base, derivatives, which rows count."""
