"""Many independent runs over processes: results in the order of the jobs, kept as they come, resumable.

A job is a name and plain settings; all its randomness follows from them. So results do not depend on how many
processes there are, on the order in which they finish, or on how often the campaign was interrupted.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import joblib

from .cli_output import plain

Result = dict[str, Any]
Work = Callable[[Mapping[str, Any]], Mapping[str, Any]]


class CampaignError(ValueError):
    """A campaign that cannot be run or resumed; one line."""


@dataclass(frozen=True, slots=True)
class Job:
    """One run: `settings` are JSON scalars by name, seed included, and all that the run depends on."""

    settings: Mapping[str, str | int | float | bool | None]

    @property
    def key(self) -> str:
        """Names the job by its settings: equal settings, equal key."""
        text = json.dumps(dict(self.settings), sort_keys=True, allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


class Store:
    """Results on disk, a line of JSON each, appended as they come. A line cut off by a kill is dropped."""

    def __init__(self, path: Path, version: str) -> None:
        """`version`: of what computes the results; lines of another version are not taken up."""
        self.path = path
        self.version = version

    def read(self) -> dict[str, Result]:
        """Results by job key. Raises: CampaignError for a file that is no store."""
        try:
            text = self.path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return {}
        except (OSError, UnicodeDecodeError) as error:
            raise CampaignError(f"{self.path}: cannot read the results kept there: {error}") from error
        results = {}
        for number, line in enumerate(text.split("\n")[:-1], 1):
            try:
                entry = json.loads(line)
                if entry["version"] == self.version:
                    results[str(entry["key"])] = dict(entry["result"])
            except (ValueError, KeyError, TypeError):
                raise CampaignError(f"{self.path}, line {number}: not a result of a campaign") from None
        return results

    def append(self, job: Job, result: Result) -> None:
        """Keeps one result; it is on disk when this returns."""
        entry = {"key": job.key, "version": self.version, "settings": dict(job.settings), "result": result}
        line = json.dumps(entry, sort_keys=True, allow_nan=False) + "\n"
        with self.path.open("a+b") as file:
            file.seek(0)
            whole = file.read().rfind(b"\n") + 1
            file.truncate(whole)  # drops a line that a kill cut off: `read` has left it out too
            file.write(line.encode())
            file.flush()
            os.fsync(file.fileno())


def run_campaign(
    jobs: Sequence[Job],
    work: Work,
    *,
    processes: int = 1,
    store: Store | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
    dask: str | None = None,
) -> list[Result]:
    """Runs every job that the store does not have yet; returns the results in the order of the jobs.

    work: a function of a module (it is sent to other processes) from settings to JSON values. progress is
    told (done, total) after each. dask: address of a Dask scheduler to run on instead of local processes.
    Raises: CampaignError; whatever `work` raises, after what had finished was kept.
    """
    results = store.read() if store else {}
    todo = list({job.key: job for job in jobs if job.key not in results}.values())
    done = len({job.key for job in jobs}) - len(todo)
    total = done + len(todo)
    progress(done, total)
    for job, result in _results(todo, work, processes, dask):
        results[job.key] = result
        if store:
            store.append(job, result)
        done += 1
        progress(done, total)
    return [results[job.key] for job in jobs]


def _results(
    jobs: Sequence[Job], work: Work, processes: int, dask: str | None
) -> Iterator[tuple[Job, Result]]:
    """Yields each job with its result, as they finish."""
    if processes == 1 and dask is None:
        for job in jobs:
            yield _one(job, work)
        return
    with _backend(dask):
        pool = joblib.Parallel(
            n_jobs=-1 if dask else processes, return_as="generator_unordered", batch_size=1
        )
        yield from pool(joblib.delayed(_one)(job, work) for job in jobs)


def _one(job: Job, work: Work) -> tuple[Job, Result]:
    result = plain(dict(work(job.settings)))
    assert isinstance(result, dict)
    return job, result


@contextlib.contextmanager
def _backend(dask: str | None) -> Iterator[None]:
    """Processes of this machine, or a Dask cluster's. Raises: CampaignError."""
    if dask is None:
        with joblib.parallel_config(backend="loky", inner_max_num_threads=1):
            yield
        return
    try:
        from distributed import Client
    except ImportError:
        raise CampaignError("--dask needs the package distributed: pip install 'tolman[dask]'") from None
    with (
        Client(dask) as client,
        joblib.parallel_config(backend="dask", client=client, wait_for_workers_timeout=60),
    ):
        yield
