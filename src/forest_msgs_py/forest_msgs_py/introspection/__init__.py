"""A running graph seen from outside: who is there, what is said, which parameters hold."""
