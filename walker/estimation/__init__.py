"""What the walker makes of its sensors: contact, measured zero moment point, falls."""

from walker.estimation.contact import ContactEstimator, Contacts
from walker.estimation.corrections import Corrections
from walker.estimation.estimator import Estimate, Estimator
from walker.estimation.fall import FallDetector

__all__ = ["ContactEstimator", "Contacts", "Corrections", "Estimate", "Estimator", "FallDetector"]
