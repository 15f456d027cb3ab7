"""One page drives; the others ask. Random sequences keep the rules."""

import random

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


def test_in_any_order_there_is_one_driver_who_asked_and_is_still_there():
    rng = random.Random(4)
    for _ in range(200):
        seat, pages, now = Seat(), {"1", "2", "3"}, 0.0
        for _ in range(60):
            now += rng.uniform(0.0, 1.0)
            before, page = seat, rng.choice(("1", "2", "3", "4"))
            act = rng.randrange(4)
            if act == 0 and page in pages:
                seat = asked(seat, page, now)
                if seat.driver != before.driver:
                    assert before.driver is None or now - before.heard > ABANDONED
            elif act == 1:
                heir = rng.choice((None, *pages)) if pages else None
                seat = left(seat, page, heir, now)
                assert page == before.driver or seat == before
            elif act == 2:
                pages.discard(page)
                seat = gone(seat, page)
            else:
                pages.add(page)
            assert seat.driver is None or seat.driver in pages
            assert set(seat.asking) <= pages
            assert seat.driver not in seat.asking
            assert len(set(seat.asking)) == len(seat.asking)
