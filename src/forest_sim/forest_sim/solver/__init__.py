"""Steps in time of the equations of motion, implicit and of second order, interpreted or compiled."""
