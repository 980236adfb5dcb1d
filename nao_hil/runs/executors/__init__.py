"""Where the runs of a campaign are carried out: in this process, in local processes, on a dask cluster."""

from nao_hil.runs.executors.base import Executor, Finished, Job, RunFailed, WorkerRefused
from nao_hil.runs.executors.choose import local_workers, open_executor

__all__ = ["Executor", "Finished", "Job", "RunFailed", "WorkerRefused", "local_workers", "open_executor"]
