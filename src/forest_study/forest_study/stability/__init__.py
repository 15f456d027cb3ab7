"""How far the position loops of machine and controller are from swinging up: Bode plots and margins."""
