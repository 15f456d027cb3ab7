"""One file of a bag in rosbag2's older format, an SQLite database (.db3), read as an MCAP file is."""

from collections import Counter
from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path

from forest_bag.storage.decompression import LARGEST
from forest_bag.storage.raw_messages import BagFile, Channel, Damaged, Piece, RawMessage, full_type
from forest_bag.storage.sqlite_open import BROKEN, Database

MAGIC = b"SQLite format 3\0"
BYTES = 1 << 24  # of a piece, or
MESSAGES = 2000  # in it, and as many more as have the last one's log time
USABLE = "typeof(timestamp) = 'integer' AND typeof(data) = 'blob' AND length(data) <= ?"
TOPIC_COLUMNS = (
    "id",
    "name",
    "type",
    "serialization_format",
    "offered_qos_profiles",
    "type_description_hash",
)


class SqlitePieces(BagFile):
    """A .db3 file; its publishers' times and sequence numbers were never kept."""

    def __init__(self, path: Path, plain: Path) -> None:
        """Open a file and find its pieces; arguments and errors as `BagFile`."""
        super().__init__(path, plain, MAGIC, ("an SQLite database", "SQLite"))
        try:
            self._database = Database(plain)
        except BROKEN as error:
            raise Damaged(f"{path} is not a readable database of rosbag2's: {error}") from error
        try:
            self.channels = self._topics()
            self.problems += self._unusable()
            self._find_pieces()
        except BROKEN as error:
            self.close()
            raise Damaged(f"{path} is not a readable database of rosbag2's: {error}") from error
        self.complete = not self.problems
        if self._database.note:
            self.notes.append(self._database.note)

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()

    def check(self) -> None:
        """Test whether the pages fit together; SQLite keeps no checksums of what is in them.

        Raises:
            Damaged: they do not.
        """
        try:
            (found,) = self._database.execute("PRAGMA quick_check(1)").fetchone()
        except BROKEN as error:
            found = str(error)
        if found != "ok":
            raise Damaged(f"{self.path} is damaged: {' '.join(found.split())}")

    def read(self, piece: Piece) -> list[RawMessage]:
        """Read the messages of a piece, in the order of their log times.

        Raises:
            Damaged: the database cannot give them.
        """
        query = f"SELECT timestamp, topic_id, data FROM messages WHERE {USABLE} AND timestamp BETWEEN ? AND ?"
        try:
            rows = self._database.execute(query, (LARGEST, piece.first_ns, piece.last_ns)).fetchall()
        except BROKEN as error:
            raise Damaged(f"{self.path} is damaged: {error}") from error
        rows.sort(key=itemgetter(0))  # not ORDER BY: without an index SQLite sorts copies of the data
        known = self.channels
        return [RawMessage(time, time, 0, known[topic], data) for time, topic, data in rows if topic in known]

    def _topics(self) -> dict[int, Channel]:
        """Topics by number; databases before Galactic keep no QoS, before Iron no hash."""
        have = {row[1] for row in self._database.execute("PRAGMA table_info(topics)")}
        definitions = self._definitions()
        wanted = ", ".join(name if name in have else f"'' AS {name}" for name in TOPIC_COLUMNS)
        return {
            number: Channel(
                topic=name,
                type=full_type(kind, encoding),
                encoding=encoding,
                qos=qos,
                type_hash=str(type_hash or ""),
                definition_format=definitions.get(kind, ("", ""))[0],
                definition=definitions.get(kind, ("", ""))[1],
            )
            for number, name, kind, encoding, qos, type_hash in self._database.execute(
                f"SELECT {wanted} FROM topics"
            )
            if all(isinstance(text, str) for text in (name, kind, encoding))
        }

    def _definitions(self) -> dict[str, tuple[str, str]]:
        """Format and text of message types by name; databases before Iron keep none."""
        query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        if not self._database.execute("PRAGMA table_info(message_definitions)").fetchall():
            return {}
        rows = self._database.execute(query).fetchall()
        return {kind: (form, text) for kind, form, text in rows if isinstance(text, str)}

    def _unusable(self) -> Iterator[str]:
        """What messages cannot be read, and why: a database checks neither references nor kinds of values."""
        query = "SELECT topic_id, typeof(timestamp), typeof(data), length(data) > ? FROM messages"
        kinds = Counter(self._database.execute(query, (LARGEST,)))  # GROUP BY would sort, with all the data
        for (topic, time, data, is_large), count in kinds.items():
            if topic not in self.channels:
                yield f"{count} of its messages name topic_id {topic}, which is not in its table of topics"
            elif (time, data) != ("integer", "blob"):
                yield f"{count} of its messages have a timestamp of kind {time} and data of kind {data}"
            elif is_large:
                yield f"{count} of its messages have more than the {LARGEST} bytes that are allowed"

    def _find_pieces(self) -> None:
        query = f"SELECT timestamp, length(data) FROM messages WHERE {USABLE} ORDER BY timestamp"
        rows = self._database.execute(query, (LARGEST,)).fetchall()
        start = 0
        while start < len(rows):
            stop, size = start, 0
            while stop < len(rows) and (
                (stop - start < MESSAGES and size < BYTES) or rows[stop][0] == rows[stop - 1][0]
            ):
                size += rows[stop][1]
                stop += 1
            self.pieces.append(Piece(rows[start][0], rows[stop - 1][0], start, stop - start))
            start = stop
