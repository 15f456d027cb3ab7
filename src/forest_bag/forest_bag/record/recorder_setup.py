"""What a recorder records, and into what, as its parameters say."""

from collections.abc import Callable
from pathlib import Path

from forest_bag.record.recorder_parameters import RecorderParameters
from forest_bag.record.topic_choice import ChoiceError, TopicChoice
from forest_bag.write.bag_session import Session
from forest_bag.write.bag_split import Layout
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.parameter_table import ParameterError


def topic_choice(p: RecorderParameters, resolve: Callable[[str], str], namespace: str) -> TopicChoice:
    """Return the choice of topics; /events is among them.

    Args:
        p: the parameters.
        resolve: makes a name absolute, as the node sees it.
        namespace: of the recorder.

    Raises:
        ParameterError: a regular expression is none.
    """
    chosen = [*p.topics, topics.EVENTS.name] if any(p.topics) or p.regex else p.topics
    try:
        return TopicChoice(resolve, namespace, chosen, p.regex, p.exclude, p.everything)
    except ChoiceError as error:
        raise ParameterError(f"parameter 'regex' or 'exclude': {error}") from error


def new_session(p: RecorderParameters) -> tuple[Session, str]:
    """Return the session, begun unless it is to start paused, and a sentence on what it waits for.

    Raises:
        ParameterError: there is no directory to be made.
    """
    refused = f"parameter 'output' is {p.output!r}: %s; allowed: a directory that does not exist yet"
    if not p.output:
        raise ParameterError(refused % "no directory")
    if Path(p.output).exists():
        raise ParameterError(refused % f"{p.output} exists")
    layout = Layout(p.compression, int(p.max_size * 1e6), int(p.max_duration * 1e9), durable=True)
    session = Session(p.output, layout, int(p.snapshot_seconds * 1e9))
    try:
        if not p.start_paused:
            session.start()
    except OSError as error:
        raise ParameterError(refused % error) from error
    begins = "paused, will record" if p.start_paused else "waits for the first message, to be recorded"
    return session, f"{begins} to {p.output}"
