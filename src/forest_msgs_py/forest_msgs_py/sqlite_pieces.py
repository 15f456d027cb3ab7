"""One file of a bag in rosbag2's older format, an SQLite database (.db3), read as an MCAP file is."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from urllib.parse import quote

from forest_msgs_py.bag_files import BagError
from forest_msgs_py.raw_messages import Channel, Damaged, Piece, RawMessage, full_type

MAGIC = b"SQLite format 3\0"
MESSAGES = 2000  # in a piece, and as many more as have the last one's log time
TOPIC_COLUMNS = (
    "id",
    "name",
    "type",
    "serialization_format",
    "offered_qos_profiles",
    "type_description_hash",
)


class SqlitePieces:
    """A .db3 file; its publishers' times and sequence numbers were never kept."""

    def __init__(self, path: Path) -> None:
        """Open a file and find its pieces.

        Raises:
            BagError: it is no database of rosbag2's.
            OSError: it cannot be read.
        """
        self.path = path
        self.pieces: list[Piece] = []
        self.complete = True
        self.problems: list[str] = []
        self.attachments: list[tuple[str, bytes]] = []
        self.metadata: list[tuple[str, dict[str, str]]] = []
        with path.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise BagError(
                    f"{path} is not an SQLite database: it does not begin with SQLite's magic bytes"
                )
        address = f"file:{quote(str(path.resolve()))}?mode=ro"
        self._database = sqlite3.connect(address, uri=True, check_same_thread=False)
        try:
            self.channels = self._topics()
            self.counts: dict[int, int] | None = dict.fromkeys(self.channels, 0)
            query = "SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id"
            self.counts.update(self._database.execute(query))
            self._find_pieces()
        except sqlite3.Error as error:
            self._database.close()
            raise Damaged(f"{path} is not a readable database of rosbag2's: {error}") from error

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()

    def read(self, piece: Piece) -> list[RawMessage]:
        """Read the messages of a piece, in the order of their log times.

        Raises:
            Damaged: the database cannot give them.
        """
        query = (
            "SELECT timestamp, topic_id, data FROM messages WHERE timestamp BETWEEN ? AND ? "
            "ORDER BY timestamp, id"
        )
        try:
            rows = self._database.execute(query, (piece.first_ns, piece.last_ns)).fetchall()
        except sqlite3.Error as error:
            raise Damaged(f"{self.path} is damaged: {error}") from error
        return [RawMessage(time, time, 0, self.channels[topic], data) for time, topic, data in rows]

    def _topics(self) -> dict[int, Channel]:
        """Topics by number; databases before Galactic keep no QoS, before Iron no hash."""
        have = {row[1] for row in self._database.execute("PRAGMA table_info(topics)")}
        wanted = ", ".join(name if name in have else f"'' AS {name}" for name in TOPIC_COLUMNS)
        return {
            number: Channel(name, full_type(kind, encoding), encoding, *rest)
            for number, name, kind, encoding, *rest in self._database.execute(f"SELECT {wanted} FROM topics")
        }

    def _find_pieces(self) -> None:
        times = [
            row[0] for row in self._database.execute("SELECT timestamp FROM messages ORDER BY timestamp")
        ]
        start = 0
        while start < len(times):
            stop = min(start + MESSAGES, len(times))
            while stop < len(times) and times[stop] == times[stop - 1]:
                stop += 1
            self.pieces.append(Piece(times[start], times[stop - 1], start, stop - start))
            start = stop
