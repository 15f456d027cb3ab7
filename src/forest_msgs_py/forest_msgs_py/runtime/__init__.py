"""What every node runs in: environment, parameters, polled subscriptions, order of stamps, services."""
