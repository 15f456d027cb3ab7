"""A bag read: raw messages in order of time, tables, time series, a survey of what is in it."""
