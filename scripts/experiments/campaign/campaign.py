"""Many independent runs over processes: results in the order of the jobs, kept as they come, resumable.

A job is a name and plain settings; all its randomness follows from them. So results do not depend on how many
processes there are, on the order in which they finish, or on how often the campaign was interrupted.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import joblib

from ...plain import plain

Scalar = str | int | float | bool | None
Result = dict[str, Any]
Work = Callable[[Mapping[str, Any]], Mapping[str, Any]]
Version = Callable[[Mapping[str, Any]], str]


class CampaignError(ValueError):
    """A campaign that cannot be run or resumed; one line."""


@dataclass(frozen=True, slots=True)
class Job:
    """One run: `settings` are JSON scalars by name, seed included, and all that the run depends on."""

    settings: Mapping[str, Scalar]

    @property
    def key(self) -> str:
        """Names the job by its settings: equal settings, equal key."""
        text = json.dumps(dict(self.settings), sort_keys=True, allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


class Store:
    """Results on disk, a line of JSON each, appended as they come. A line cut off by a kill is dropped."""

    def __init__(self, path: Path, version: str | Version) -> None:
        """`version`: of what computes the results, or a function of a job's settings that tells it; lines of
        another version are not taken up.
        """
        self.path = path
        self._version: Version = version if callable(version) else lambda settings: version

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
                if entry["version"] == self._version(entry["settings"]):
                    results[str(entry["key"])] = dict(entry["result"])
            except (ValueError, KeyError, TypeError):
                raise CampaignError(f"{self.path}, line {number}: not a result of a campaign") from None
        return results

    def append(self, job: Job, result: Result) -> None:
        """Keeps one result; it is on disk when this returns."""
        settings = dict(job.settings)
        version = self._version(settings)
        entry = {"key": job.key, "version": version, "settings": settings, "result": result}
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
    progress: Callable[[Progress], None] = lambda progress: None,
    cost: Callable[[Job], float] = lambda job: 1.0,
    until: float | None = None,
    dask: str | None = None,
    failed: Callable[[Job, str], None] | None = None,
) -> dict[str, Result]:
    """Begins the jobs that the store does not have yet, in their order; returns results by job key.

    work: a function of a module (it is sent to other processes) from settings to JSON values. progress is
    told after each; cost: what a job takes, in any unit, to tell how long the rest will. until: no job is
    begun after this time (`time.monotonic`), so that some keys may be missing. dask: address of a Dask
    scheduler to run on instead of local processes.
    failed is told of jobs that raised an error, and what, while the others go on; without it the campaign
    ends.
    Raises: CampaignError; without `failed` whatever `work` raises, after what had finished was kept.
    """
    results = store.read() if store else {}
    unique = {job.key: job for job in jobs}
    todo = [job for key, job in unique.items() if key not in results]
    clock = _Clock(len(unique), [cost(job) for job in todo])
    progress(clock.progress())
    if not todo:
        return {key: results[key] for key in unique}

    def begun() -> Iterator[Job]:
        for job in todo:
            if until is not None and time.monotonic() >= until:
                return
            yield job

    attempt = work if failed is None else partial(_guarded, work=work)
    for job, result in _results(begun(), attempt, processes, dask):
        clock.done(cost(job))
        if failed is not None and _ERROR in result:
            failed(job, str(result[_ERROR]))
            continue
        results[job.key] = result
        if store:
            store.append(job, result)
        progress(clock.progress())
    return {key: results[key] for key in unique if key in results}


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a campaign is. seconds_left: a guess, None before anything has finished."""

    done: int
    total: int
    seconds_left: float | None


class _Clock:
    """Guesses how long the rest takes: as long for its cost as what has finished took."""

    def __init__(self, total: int, costs: Sequence[float]) -> None:
        self._total = total
        self._left = len(costs)
        self._cost, self._finished = math.fsum(costs), 0.0
        self._began = time.monotonic()

    def done(self, cost: float) -> None:
        self._left -= 1
        self._finished += cost

    def progress(self) -> Progress:
        seconds = None
        if self._finished > 0.0:
            spent = time.monotonic() - self._began
            seconds = spent * max(0.0, self._cost - self._finished) / self._finished
        return Progress(self._total - self._left, self._total, seconds)


def _results(
    jobs: Iterable[Job], work: Work, processes: int, dask: str | None
) -> Iterator[tuple[Job, Result]]:
    """Yields each job with its result, as they finish."""
    if processes == 1 and dask is None:
        for job in jobs:
            yield _one(job, work)
        return
    with _backend(dask):
        pool = joblib.Parallel(
            n_jobs=-1 if dask else processes,
            return_as="generator_unordered",
            batch_size=1,
            pre_dispatch="n_jobs",  # a job is begun when a process is free: the order is kept, and `until`
        )
        yield from pool(joblib.delayed(_one)(job, work) for job in jobs)


_ERROR = "error of the run"


def _guarded(settings: Mapping[str, Any], work: Work) -> Mapping[str, Any]:
    """The work, which tells of an error instead of raising it."""
    try:
        return work(settings)
    except Exception as error:  # one run of hundreds must not take the others with it
        where = traceback.extract_tb(error.__traceback__)[-1]
        at = f"{Path(where.filename).name}:{where.lineno}"
        return {_ERROR: f"{type(error).__name__} at {at}: {' '.join(str(error).split())}"}


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
    connect: Any = Client  # partly typed where it is installed
    with (
        connect(dask) as client,
        joblib.parallel_config(backend="dask", client=client, wait_for_workers_timeout=60),
    ):
        yield
