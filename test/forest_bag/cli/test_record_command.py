"""`forest-bag record`: flags become the recorder's parameters; a status line tells how it is going."""

import argparse

import pytest

from forest_bag.cli import record_command
from forest_bag.record.progress import RecordingStatus, status_line


def asked(*arguments):
    parser = argparse.ArgumentParser()
    record_command.add_parser(parser.add_subparsers())
    return record_command.parameters(parser.parse_args(["record", *arguments]))


def test_without_a_choice_everything_is_recorded_into_a_directory_named_by_the_time():
    parameters = asked()
    assert parameters.pop("output").startswith("rosbag2_20")
    assert parameters == {"everything": True, "compression": "zstd"}


def test_flags_become_parameters():
    flags = ["-o", "x", "--topics", "/a", "b", "-e", "^/c", "--exclude", "/c/d", "--compression", "lz4"]
    flags += ["--max-duration", "60", "--max-size", "100", "--snapshot-seconds", "30", "--start-paused"]
    assert asked(*flags) == {
        "output": "x",
        "topics": ["/a", "b"],
        "regex": "^/c",
        "exclude": ["/c/d"],
        "everything": True,
        "compression": "lz4",
        "max_duration": 60.0,
        "max_size": 100.0,
        "snapshot_seconds": 30.0,
        "start_paused": True,
    }


def test_the_words_of_ros2_bag_are_understood():
    parameters = asked("/a", "/b", "-o", "x", "-b", "2000000", "--max-bag-duration", "5")
    assert parameters["topics"] == ["/a", "/b"]
    assert parameters["max_size"] == 2.0
    assert parameters["max_duration"] == 5.0
    assert "topics" not in asked("-a")
    assert asked("-d", "0")["max_duration"] == 0.0


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--regex", "("], "'(' is not a regular expression"),
        (["--max-size", "much"], "'much'; allowed: 0 .. 1e+09"),
        (["--max-duration", "-1"], "'-1'; allowed: 0 .. 1e+09"),
        (["--compression", "gzip"], "lz4"),
        (["--node-name", "1x"], "'1x'; allowed: letters, digits and _, not a digit first"),
        (["--namespace", "/crane/2"], "'2'; allowed: letters, digits and _, not a digit first"),
    ],
)
def test_a_wrong_flag_says_what_is_allowed(flags, words, capsys):
    with pytest.raises(SystemExit, match="2"):
        asked(*flags)
    assert words in capsys.readouterr().err


def test_the_status_line_tells_duration_size_rate_and_losses():
    assert status_line(3725.25, 12_345_678, 1000, 200.4, 7) == (
        "1:02:05.2, 12.35 MB, 1000 messages, 200/s, lost 7"
    )


def test_without_a_terminal_a_line_comes_every_ten_seconds(capsys):
    lines = []
    status = RecordingStatus(lines.append, 0.0)
    for tenth in range(300):
        if status.due(tenth / 10):
            status.show(tenth / 10, 0, tenth * 20, 0)
    status.end()
    assert [line.split(",")[0] for line in lines] == ["0:00:10.0", "0:00:20.0"]
    assert all("200/s" in line for line in lines)
    assert capsys.readouterr().out == ""


def test_on_a_terminal_the_line_overwrites_itself(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    status = RecordingStatus(pytest.fail, 0.0)
    assert status.due(0.5)
    status.show(0.5, 0, 100, 0)
    status.end()
    assert capsys.readouterr().out == "\r\x1b[K0:00:00.5, 0.00 MB, 100 messages, 200/s, lost 0\n"
