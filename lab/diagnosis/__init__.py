"""What went wrong first, from frames alone: pure, the same live, on a recording and in a test."""

from lab.diagnosis.balance import Balance, Observer, Plan, Stand
from lab.diagnosis.diagnose import Diagnosis, diagnose, explain, recorded_body, symptoms_of
from lab.diagnosis.moment import Gatherer, Moment, moments
from lab.diagnosis.symptoms import Symptom, Symptoms

__all__ = [
    "Balance",
    "Diagnosis",
    "Gatherer",
    "Moment",
    "Observer",
    "Plan",
    "Stand",
    "Symptom",
    "Symptoms",
    "diagnose",
    "explain",
    "moments",
    "recorded_body",
    "symptoms_of",
]
