"""The examples of pages whose nodes run live."""

import pytest
from page_reader import PAGES, is_live, read, workplace


@pytest.mark.parametrize("page", [page for page in PAGES if is_live(page)])
def test_a_live_page_runs_as_it_is_written(page, tmp_path, domain_id):
    read(page, tmp_path, workplace(tmp_path, domain_id))
