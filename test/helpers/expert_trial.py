"""A trial of log work that several files look at: who needs it first in a run of the suite makes it."""

import os
import pickle

from forest_description.machine import load_machine
from forest_study.log_work import trial
from forest_study.log_work.person import drawn, read_person

TRIAL = load_machine("forwarder"), "tip", drawn(read_person("expert"), 0), 0.0, 0


def expert_trial(tmp_path_factory):
    """Return what `trial.work` gives of `TRIAL`; workers of one run find it in the folder that they share."""
    own = tmp_path_factory.getbasetemp()
    file = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "expert_trial.pickle"
    if not file.exists():
        (own / "made").write_bytes(pickle.dumps(trial.work(*TRIAL)))
        (own / "made").replace(file)
    return pickle.loads(file.read_bytes())
