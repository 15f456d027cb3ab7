"""A bag played in time: what is asked for, reading ahead, timing, remote control."""
