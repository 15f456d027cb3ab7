"""The examples of pages whose reader changes the sources and looks at no bag."""

import pytest
from page_reader import PAGES, changes_sources, is_live, looks_at_the_demo, read, workplace

HERE = [page for page in PAGES if changes_sources(page) and not looks_at_the_demo(page) and not is_live(page)]


@pytest.mark.parametrize("page", HERE)
def test_a_page_runs_as_it_is_written(page, tmp_path, lockstep_domain_id):
    read(page, tmp_path, workplace(tmp_path, lockstep_domain_id))
