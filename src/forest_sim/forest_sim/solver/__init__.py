"""The equations of motion together, and their steps in time, interpreted or compiled."""
