"""What happens when machine and control meet: closed loops of the pure cores, the live graph's supervisor."""
