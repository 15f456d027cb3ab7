"""Parameters of the recorder's node."""

from typing import Annotated, NamedTuple

from forest_bag.storage.mcap_chunk import COMPRESSIONS
from forest_msgs_py.runtime.parameter_table import Parameter, tunable

HOUR = 3600.0  # [s]; readers load a file's index whole, which has ten entries for each second


class RecorderParameters(NamedTuple):
    """Of `recorder_node`; what follows a run in lockstep are `ListenerParameters`."""

    topics: Annotated[tuple[str, ...], Parameter("topics to record; empty: all")] = ("",)
    regex: Annotated[
        str, Parameter("regular expression: topics to record, in place of all or beside `topics`")
    ] = ""
    exclude: Annotated[tuple[str, ...], Parameter("topics to leave out: names or regular expressions")] = (
        "",
    )
    everything: Annotated[bool, Parameter("record all namespaces, not only the recorder's")] = False
    output: Annotated[str, Parameter("directory to be made for the bag")] = ""
    compression: Annotated[str, Parameter("compression of the chunks", choices=COMPRESSIONS)] = "zstd"
    max_duration: Annotated[float, Parameter("longest file; 0: no limit", "s", 0.0, 1e9)] = HOUR
    max_size: Annotated[float, Parameter("largest file; 0: no limit", "MB", 0.0, 1e9)] = 0.0
    snapshot_seconds: Annotated[
        float,
        Parameter("time kept in memory and written on ~/snapshot; 0: write everything", "s", 0.0, 3600.0),
    ] = 0.0
    start_paused: Annotated[bool, Parameter("begin to record at ~/start")] = False
    qos_profile_overrides_path: Annotated[
        str,
        Parameter("YAML file of the subscriptions' QoS; empty: what suits all publishers"),
    ] = ""
    event: Annotated[str, tunable("text of the next `mark` on /events")] = "mark"
