"""Parameters of the recorder's node."""

from pathlib import Path
from typing import Annotated, NamedTuple

from forest_bag.storage.mcap_chunk import COMPRESSIONS
from forest_msgs_py.interfaces.qos_overrides import QosOverrideError, read_overrides
from forest_msgs_py.interfaces.qos_profiles import Qos
from forest_msgs_py.runtime.parameter_table import Parameter, ParameterError, tunable

HOUR = 3600.0  # [s]; readers load a file's index whole, which has ten entries for each second


class RecorderParameters(NamedTuple):
    """Of `recorder_node`; what follows a run in lockstep are `ListenerParameters`."""

    topics: Annotated[tuple[str, ...], Parameter("record only these")] = ("",)
    regex: Annotated[str, Parameter("record only, or also, topics whose name contains this")] = ""
    exclude: Annotated[
        tuple[str, ...], Parameter("names, or regular expressions, of topics not to record")
    ] = ("",)
    everything: Annotated[bool, Parameter("record all namespaces, not only the recorder's")] = False
    output: Annotated[str, Parameter("Directory to be made for the bag")] = ""
    compression: Annotated[str, Parameter("of the chunks", choices=COMPRESSIONS)] = "zstd"
    max_duration: Annotated[float, Parameter("longest file; 0: no limit", "s", 0.0, 1e9)] = HOUR
    max_size: Annotated[float, Parameter("largest file; 0: no limit", "MB", 0.0, 1e9)] = 0.0
    snapshot_seconds: Annotated[
        float,
        Parameter("keep so much in memory and write it on ~/snapshot; 0: write everything", "s", 0.0, 3600.0),
    ] = 0.0
    start_paused: Annotated[bool, Parameter("record nothing before ~/start")] = False
    qos_profile_overrides_path: Annotated[
        str,
        Parameter("YAML file: QoS of subscriptions to topics, in place of what suits all publishers"),
    ] = ""
    event: Annotated[str, tunable("what the next `mark` says on /events")] = "mark"


def overrides(p: RecorderParameters) -> dict[str, Qos]:
    """Return the QoS of subscriptions that the user's file names, by topic.

    Raises:
        ParameterError: the file cannot be read, or something in it is not allowed.
    """
    path = p.qos_profile_overrides_path
    try:
        return read_overrides(Path(path)) if path else {}
    except (QosOverrideError, OSError) as error:
        raise ParameterError(f"parameter 'qos_profile_overrides_path': {error}") from error
