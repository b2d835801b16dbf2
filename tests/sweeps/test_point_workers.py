"""Worker processes use one thread each, unless the user says otherwise, and leave this process as it was."""

import os

import pytest

from cyclemap.sweeps.point_workers import own_executor

VARIABLES = ("OPENBLAS_NUM_THREADS", "CYCLEMAP_THREADS")


@pytest.mark.slow
@pytest.mark.parametrize("said", [{}, {"CYCLEMAP_THREADS": "3"}, {"OPENBLAS_NUM_THREADS": "2"}])
def test_workers_have_one_thread_each_where_nothing_else_is_said(monkeypatch, said) -> None:
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
    for name, value in said.items():
        monkeypatch.setenv(name, value)
    before = dict(os.environ)
    with own_executor(2) as pool:
        found = {name: pool.submit(os.getenv, name).result() for name in VARIABLES}
    assert found == dict.fromkeys(VARIABLES, "1") | said
    assert dict(os.environ) == before


def test_one_worker_is_this_process_with_its_own_threads(monkeypatch) -> None:
    monkeypatch.delenv("CYCLEMAP_THREADS", raising=False)
    with own_executor(1) as pool:
        assert pool.submit(os.getpid).result() == os.getpid()
        assert pool.submit(os.getenv, "CYCLEMAP_THREADS").result() is None
