"""How far the position loops of machine and controller are from instability: Bode plots and margins."""
