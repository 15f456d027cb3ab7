"""The schemes' loops: from a tip velocity to joint rates, closed on the tip's position."""
