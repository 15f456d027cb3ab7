"""All experiments together: from sessions to a machine, with intervals."""
