"""Whether a message is newer than those before it: what overtook it must not be undone."""

NO_STAMP = 0  # [ns]


class StampOrder:
    """Tells the messages of one topic that come in order from those that do not.

    Args:
        patience: when nothing in order has come for this long [s], the sender's time may begin anew with a
            stamp that goes back: it was started again, or its clock was set. What rises from there on is in
            order.
    """

    def __init__(self, patience: float) -> None:
        self._patience = patience
        self._newest: int | None = None
        self._accepted = 0.0

    def problem(self, name: str, stamp_ns: int, now: float) -> str:
        """Return what is wrong with a message's stamp, or "" and take it as the newest.

        Args:
            name: of the topic, for the text.
            stamp_ns: the message's; `NO_STAMP` is always in order.
            now: local monotonic time [s].
        """
        if stamp_ns == NO_STAMP:
            return ""
        newest, since = self._newest, now - self._accepted
        if newest is None or stamp_ns > newest:
            self._newest, self._accepted = stamp_ns, now
            return ""
        if stamp_ns == newest:
            return f"{name}: the stamp stands still; allowed: rising stamps, or none"
        if since > self._patience:
            self._newest, self._accepted = stamp_ns, now
        back = (newest - stamp_ns) * 1e-9
        return f"{name}: the stamp goes back by {back:g} s; allowed: rising stamps, or none"
