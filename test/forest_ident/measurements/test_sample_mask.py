"""What a refinement leaves out of a bench's record."""

import numpy as np

from forest_ident.measurements import sample_mask
from forest_ident.measurements.session import Session


def test_a_flow_that_turns_round_between_two_rows_counts_as_shut_there():
    flow = np.where(np.arange(200) < 100, 1e-3, -1e-3)  # never next to zero, but its valve was
    record = Session("hose", 0.005 * np.arange(200), np.zeros((200, 3)), {"swing_flow": flow})
    columns = {"swing_pressure_1_valve": np.ones(200), "swing_spool": np.ones(200)}
    kept = sample_mask.while_open(columns, record, settled=0.0, floor=0.0)
    left_out = np.flatnonzero(np.isnan(kept["swing_pressure_1_valve"]))
    assert {*range(91, 109)} <= {*left_out.tolist()} <= {*range(85, 116), *range(12)}
    assert not np.isnan(kept["swing_spool"]).any()
