"""Diagnosis of a fall, from frames alone: pure, the same live, on a recording and in a test."""

from nao_hil.analysis.diagnosis.balance import Balance, BalanceEstimator, PlannedStand, Stand
from nao_hil.analysis.diagnosis.diagnose import Diagnosis, diagnose, explain, symptoms_of
from nao_hil.analysis.diagnosis.symptoms import Symptom, Symptoms

__all__ = [
    "Balance",
    "BalanceEstimator",
    "Diagnosis",
    "PlannedStand",
    "Stand",
    "Symptom",
    "Symptoms",
    "diagnose",
    "explain",
    "symptoms_of",
]
