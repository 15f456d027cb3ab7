"""Files on disk: MCAP chunk by chunk, SQLite of older bags, `metadata.yaml`.

- `mcap_records`, `mcap_chunk`, `mcap_file`: MCAP written: a record, a chunk, a file.
- `mcap_reader`, `mcap_recovery`: MCAP read, and read from a damaged file.
- `sqlite_file`, `sqlite_open`, `sqlite_reader`: The same of SQLite.
- `metadata`, `bag_files`: What binds the files of a bag together.
- `append_file`: A file to which pieces are appended whole or not at all.
- `raw_messages`, `decompression`: Messages as bytes; compressed bytes, within bounds.
"""
