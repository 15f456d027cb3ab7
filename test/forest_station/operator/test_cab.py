"""Seat, deadman and levers together: what /joy is told."""

from forest_station.operator.cab import Cab
from forest_station.operator.deadman import State
from forest_station.operator.hands_message import Hands

BUTTON, TIMEOUT = 9, 0.08
CENTRED, UP = (0.0,) * 6, (0.0, 0.0, 0.0, 0.5, 0.0, 0.0)


class Driver:
    """Pages that drive one cab."""

    def __init__(self, page="1"):
        self.cab, self.page, self.now, self.number = Cab(BUTTON), page, 10.0, 0

    def send(self, held, axes=CENTRED, buttons=0, page=None):
        self.number += 1
        self.now += 0.02
        hands = Hands(held, self.number, self.now, axes, buttons, self.number - 1)
        heard = self.cab.hear(page or self.page, hands, self.now)
        if heard:
            self.cab.sent_pong(self.number, self.now)
        return heard

    def drive(self):
        self.cab.take(self.page, self.now)
        for held in (False, False, True):
            self.send(held)
        self.send(True, UP)
        return self

    @property
    def joy(self):
        return self.cab.joystick()


def test_a_driver_moves_the_levers_and_holds_the_button():
    joy = Driver().drive().joy
    assert joy.axes == UP
    assert joy.buttons[BUTTON] == 1
    assert sum(joy.buttons) == 1


def test_without_a_driver_the_levers_are_centred_and_no_button_is_pressed():
    assert Driver().joy.axes == CENTRED
    assert not any(Driver().joy.buttons)


def test_the_pages_own_bit_of_the_deadmans_button_counts_for_nothing():
    driver = Driver()
    driver.cab.take("1", driver.now)
    for _ in range(5):
        driver.send(False, buttons=0b11 | 1 << BUTTON)
    assert driver.joy.buttons == tuple(int(place in (0, 1)) for place in range(21))


def test_who_takes_a_seat_is_told_whether_it_is_theirs():
    driver = Driver()
    assert driver.cab.take("1", 10.0)
    assert not driver.cab.take("2", 10.0)
    assert driver.cab.take("1", 10.0)


def test_a_driver_that_is_heard_keeps_the_seat():
    driver = Driver().drive()
    for _ in range(150):  # 3 s
        driver.send(False)
    assert not driver.cab.take("2", driver.now)
    assert driver.cab.take("2", driver.now + 2.1)


def test_a_page_that_tells_of_no_pong_holds_nothing():
    driver = Driver()
    driver.cab.take("1", driver.now)
    for held in (False, False, True, True):
        driver.number += 1
        driver.cab.hear("1", Hands(held, driver.number, driver.now, CENTRED, 0, 0), driver.now)
    assert driver.cab.deadman.state == State.WAITING


def test_a_heartbeat_counts_until_its_timeout():
    driver = Driver().drive()
    driver.cab.judge(driver.now + TIMEOUT - 1e-6)
    assert driver.joy.axes == UP


def test_hands_of_a_page_that_does_not_drive_are_ignored():
    driver = Driver().drive()
    before, cab = driver.joy, driver.cab.deadman
    assert not driver.send(False, CENTRED, page="2")
    assert driver.joy == before
    assert driver.cab.deadman == cab


def test_without_heartbeats_the_levers_are_centred_and_the_button_is_released():
    driver = Driver().drive()
    before = driver.joy
    driver.cab.judge(driver.now + TIMEOUT)
    assert driver.joy.axes == CENTRED
    assert not any(driver.joy.buttons)
    assert driver.joy.heartbeat > before.heartbeat  # or the controller would take it for repeated


def test_each_heartbeat_counts_one_and_nothing_else_does():
    driver = Driver().drive()
    count = driver.joy.heartbeat
    driver.send(True, UP)
    assert driver.joy.heartbeat == count + 1
    driver.number -= 1
    driver.send(True, CENTRED)  # its number is not new
    assert (driver.joy.heartbeat, driver.joy.axes) == (count + 1, UP)


def test_handed_over_the_deadman_must_be_pressed_anew():
    driver = Driver().drive()
    driver.cab.leave("1", "2", driver.now)
    assert driver.cab.deadman.state == State.WAITING
    assert driver.joy.axes == CENTRED
    assert not any(driver.joy.buttons)
    driver.page, driver.number = "2", 1000
    for _ in range(5):
        driver.send(True)
    assert driver.cab.deadman.state == State.WAITING
    driver.send(False)
    driver.send(True)
    assert driver.cab.deadman.state == State.HELD


def test_a_driver_that_goes_is_a_released_deadman():
    driver = Driver().drive()
    driver.cab.gone("1")
    assert driver.cab.seat.driver is None
    assert not any(driver.joy.buttons)
    assert driver.joy.axes == CENTRED


def test_a_stop_leaves_the_levers_told_and_the_button_released():
    driver = Driver().drive()
    driver.cab.stop("The emergency stop is pressed.")
    assert driver.joy.axes == UP  # a reset is refused while they are not centred
    assert not any(driver.joy.buttons)
    driver.send(True, UP)
    assert not any(driver.joy.buttons)


def test_a_slow_answer_to_a_page_is_a_slow_network():
    driver = Driver()
    driver.cab.take("1", driver.now)
    for k in range(20):
        driver.send(k > 10)
        driver.cab._pongs = {number: at - 0.3 for number, at in driver.cab._pongs.items()}
    assert driver.cab.deadman.state == State.WAITING
