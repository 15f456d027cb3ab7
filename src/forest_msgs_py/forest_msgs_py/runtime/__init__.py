"""What every node runs in: environment, parameters, polled subscriptions, stamps, services, publishers."""
