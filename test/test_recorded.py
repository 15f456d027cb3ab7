"""Recordings that are no part of the checkout are found where they are, and nowhere in silence."""

import pytest
from recorded import VARIABLE, recorded


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A checkout with a recording in shared/data beside it."""
    monkeypatch.delenv(VARIABLE, raising=False)
    beside = tmp_path / "shared" / "data"
    beside.mkdir(parents=True)
    (beside / "levers.csv").touch()
    return tmp_path / "checkout"


def test_a_recording_beside_the_checkout_is_found(checkout):
    assert recorded("levers.csv", checkout) == checkout.parent / "shared" / "data" / "levers.csv"


def test_the_folder_that_is_named_comes_first(checkout, tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    assert recorded("levers.csv", checkout).parent == checkout.parent / "shared" / "data"
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "levers.csv").touch()
    assert recorded("levers.csv", checkout).parent == tmp_path / "mine"


@pytest.mark.parametrize("named", [None, "mine"])
def test_a_skip_says_where_it_looked(checkout, tmp_path, monkeypatch, named):
    if named:
        monkeypatch.setenv(VARIABLE, str(tmp_path / named))
    with pytest.raises(pytest.skip.Exception) as skipped:
        recorded("crane.csv", checkout)
    beside = tmp_path / "shared" / "data"
    looked = (
        f"{tmp_path / named} nor in {beside}" if named else f"{beside}; {VARIABLE} may name another folder"
    )
    assert str(skipped.value) == f"crane.csv is not in {looked}"
