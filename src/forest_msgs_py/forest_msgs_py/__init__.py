"""How the nodes *talk*: the table of topics, messages and bytes, the frame of a node, lockstep.

In the order in which data passes:

- `types`: The period of 5 ms, and time in nanoseconds.
- `interfaces`: What is said: topics with types, units, rates and QoS; messages, stamps, definitions.
- `serialization`: Numbers to CDR bytes and back, one message at a time or many at once.
- `runtime`: What every node runs in: environment, parameters, polled subscriptions, order of stamps,
  services.
- `safety`: What every node does about danger: the emergency stop, and diagnostics of its inputs.
- `introspection`: A running graph seen from outside: who is there, what is said, which parameters hold.
- `clock`: A node's time: the system's clock live, the graph's steps in lockstep.

May import: `forest_compile`.
"""
