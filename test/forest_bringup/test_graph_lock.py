"""Claims about the lock of a graph: one in each ROS domain and namespace, while its process has it."""

import os

import pytest

from forest_bringup.graph_lock import AlreadyRunning, GraphError, only_graph


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Locks of their own, in domain 7."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    return tmp_path


def test_a_second_graph_is_refused_with_who_holds_the_lock_and_what_is_allowed():
    with only_graph("/crane"), pytest.raises(AlreadyRunning) as refused, only_graph("/crane"):
        pytest.fail("entered")
    assert str(refused.value) == (
        f"a graph is already running in ROS domain 7, namespace /crane (pid {os.getpid()}); "
        "stop it, or choose another --namespace or ROS_DOMAIN_ID"
    )


def test_the_lock_goes_with_its_holder_and_leaves_no_older_pid(folder):
    with only_graph("/crane"):
        pass
    (lock,) = folder.iterdir()
    lock.write_text("123456789")
    with only_graph("/crane"):
        assert lock.read_text() == str(os.getpid())


def test_a_lock_whose_holder_has_not_told_its_pid_is_a_lock(folder):
    with only_graph("/crane"):
        (lock,) = folder.iterdir()
        lock.write_text("")
        with pytest.raises(AlreadyRunning, match="pid unknown"), only_graph("/crane"):
            pytest.fail("entered")


def test_other_namespaces_and_other_domains_are_other_graphs(monkeypatch):
    with only_graph("/"), only_graph("/crane"), only_graph("/crane/two"):
        monkeypatch.setenv("ROS_DOMAIN_ID", "8")
        with only_graph("/crane"):
            pass


@pytest.mark.parametrize("domain", [None, ""])
def test_without_a_domain_it_is_zero(monkeypatch, domain):
    if domain is None:
        monkeypatch.delenv("ROS_DOMAIN_ID")
    else:
        monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    with only_graph("/"):
        monkeypatch.setenv("ROS_DOMAIN_ID", "0")
        with pytest.raises(AlreadyRunning, match="ROS domain 0"), only_graph("/"):
            pytest.fail("entered")


@pytest.mark.parametrize("domain", ["233", "-1", "1.0", "x", "²", "٣", " "])
def test_what_is_no_domain_is_refused_with_what_is_allowed(monkeypatch, domain):
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    with pytest.raises(GraphError) as refused, only_graph("/"):
        pytest.fail("entered")
    assert str(refused.value) == f"ROS_DOMAIN_ID is {domain!r}; allowed: 0 .. 232"


@pytest.mark.parametrize("domain", ["0", "232"])
def test_the_first_and_the_last_domain_are_domains(monkeypatch, domain):
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    with only_graph("/"):
        pass


def test_a_lock_that_cannot_be_written_is_named(monkeypatch, folder):
    monkeypatch.setattr("tempfile.tempdir", str(folder / "absent"))
    with (
        pytest.raises(GraphError, match=r"cannot write the lock file .*absent.*: No such file"),
        only_graph("/"),
    ):
        pytest.fail("entered")
