"""Files on disk: MCAP chunk by chunk, SQLite of older bags, `metadata.yaml`."""
