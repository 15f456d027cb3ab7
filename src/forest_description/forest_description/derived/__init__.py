"""What follows from a machine's numbers: limits, speeds, bodies, warm and cold oil, the hoses' bandwidth."""
