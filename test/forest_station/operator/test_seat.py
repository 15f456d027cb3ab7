"""One page drives; the others ask. Any sequence keeps the rules."""

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from properties import holds

from forest_station.operator.seat import Seat, asked, gone, heard, is_abandoned, left

ABANDONED = 2.0  # [s]


def test_a_free_seat_is_given_and_a_taken_one_is_asked_for():
    seat = asked(Seat(), "1", 0.0)
    assert seat.driver == "1"
    seat = asked(seat, "2", 0.1)
    assert (seat.driver, seat.asking) == ("1", ("2",))
    assert asked(seat, "2", 0.2) == seat


def test_the_driver_hands_over_and_nobody_else_can():
    seat = asked(asked(Seat(), "1", 0.0), "2", 0.1)
    assert left(seat, "2", "2", 0.2) == seat
    seat = left(seat, "1", "2", 0.2)
    assert (seat.driver, seat.asking) == ("2", ())
    assert left(seat, "2", None, 0.3).driver is None


def test_who_asks_gets_the_seat_of_a_silent_driver():
    seat = heard(asked(Seat(), "1", 0.0), 5.0)
    assert asked(seat, "2", 5.0 + ABANDONED).driver == "1"
    assert not is_abandoned(seat, 5.0 + ABANDONED)
    assert asked(seat, "2", 5.01 + ABANDONED).driver == "2"
    assert not is_abandoned(Seat(), 100.0)


def test_a_driver_that_goes_leaves_the_seat_free_and_an_asker_that_goes_is_forgotten():
    seat = asked(asked(Seat(), "1", 0.0), "2", 0.1)
    assert gone(seat, "1") == Seat(None, 0.0, ("2",))
    assert gone(seat, "2").asking == ()


PAGES = st.sampled_from(("1", "2", "3"))


class Seated(RuleBasedStateMachine):
    """Pages that come, ask, leave, hand over and go."""

    def __init__(self):
        super().__init__()
        self.seat, self.there, self.now = Seat(), set(), 0.0

    @rule(seconds=st.sampled_from((0.1, 1.9, 2.1)), speaks=st.booleans())
    def time_goes_on(self, seconds, speaks):
        self.now += seconds
        self.seat = heard(self.seat, self.now) if speaks else self.seat

    @rule(page=PAGES)
    def asks(self, page):
        self.there.add(page)
        before, self.seat = self.seat, asked(self.seat, page, self.now)
        if self.seat.driver != before.driver:
            assert self.seat.driver == page
            assert before.driver is None or self.now - before.heard > ABANDONED
        else:
            assert page == before.driver or page in self.seat.asking

    @rule(page=PAGES, heir=st.none() | PAGES)
    def leaves(self, page, heir):
        heir = heir if heir in self.there else None
        before, self.seat = self.seat, left(self.seat, page, heir, self.now)
        assert self.seat.driver == heir if page == before.driver else self.seat == before

    @rule(page=PAGES)
    def goes(self, page):
        self.there.discard(page)
        self.seat = gone(self.seat, page)

    @invariant()
    def there_is_one_driver_who_is_still_there(self):
        assert self.seat.driver is None or self.seat.driver in self.there
        assert set(self.seat.asking) <= self.there - {self.seat.driver}
        assert len(set(self.seat.asking)) == len(self.seat.asking)


def test_in_any_order_there_is_one_driver_who_asked_and_is_still_there():
    holds(Seated, examples=30, steps=20)
