"""Walks on disk: one data set per folder, a row a walk, each under the key of all that it depends on."""

from nao_hil.runs.dataset.dataset import Dataset
from nao_hil.runs.store import Row, row

__all__ = ["Dataset", "Row", "row"]
