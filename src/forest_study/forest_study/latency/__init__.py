"""What late links cost."""
