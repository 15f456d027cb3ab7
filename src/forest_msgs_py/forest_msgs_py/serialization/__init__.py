"""Numbers to CDR bytes and back, one message at a time or many at once."""
