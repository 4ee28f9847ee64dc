"""Diagnosis of the gap between measured runs and their nominal model."""

from locosweep.diagnosis.pipeline import diagnose as diagnose
from locosweep.diagnosis.result import REGIMES as REGIMES
from locosweep.diagnosis.result import Diagnosis as Diagnosis
from locosweep.diagnosis.result import Trace as Trace
