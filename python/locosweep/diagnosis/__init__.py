"""Diagnosis of the gap between measured runs and their nominal model."""

from locosweep.diagnosis.data.regimes import REGIMES as REGIMES
from locosweep.diagnosis.pipeline import diagnose as diagnose
from locosweep.diagnosis.report.result import Diagnosis as Diagnosis
from locosweep.diagnosis.report.result import Trace as Trace
from locosweep.diagnosis.screening import Screen as Screen
from locosweep.diagnosis.screening import screen as screen
