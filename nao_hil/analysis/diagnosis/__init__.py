"""Diagnosis of a fall, from frames alone: pure, the same live, on a recording and in a test."""

from nao_hil.analysis.diagnosis.balance import (
    Balance,
    BalanceEstimator,
    Moment,
    MomentBuilder,
    PlannedStand,
    Stand,
    moments,
)
from nao_hil.analysis.diagnosis.diagnose import Diagnosis, diagnose, explain, symptoms_of
from nao_hil.analysis.diagnosis.symptoms import Symptom, Symptoms

__all__ = [
    "Balance",
    "BalanceEstimator",
    "Diagnosis",
    "Moment",
    "MomentBuilder",
    "PlannedStand",
    "Stand",
    "Symptom",
    "Symptoms",
    "diagnose",
    "explain",
    "moments",
    "symptoms_of",
]
