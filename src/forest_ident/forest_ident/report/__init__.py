"""The results as a page, plots and a machine file (`machine_writer`)."""
