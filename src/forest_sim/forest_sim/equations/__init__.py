"""The equations of motion: states, constants, links and drive, put together from the parts' laws."""
