"""Identifies a robot's joint torque and position sensors, and gravity in its base frame, from static poses.

>>> from gravcal import Session
>>> result = Session.from_toml("session.toml").calibrate()
>>> result["joint"].verdict
'determined'
>>> gain = result["joint"].parameters["joint1.torque_gain"]
>>> gain.value, gain.std, gain.unit

Inside and in results: SI units and radians, ``reading = torque_gain * torque + torque_bias`` and
``coordinate = position_gain * reading + position_offset``. What the readings do not determine has no value, says why, and what to do.
"""

from importlib.metadata import PackageNotFoundError, version

from .commands import Comparison, Inspection, Study, apply, compare, export, inspect, simulate, study
from .errors import GravcalError, InputError
from .models import Poses, SensorModel, SensorParameter
from .recording import Recording, read
from .residuals import Observed, ResidualModel
from .result import (
    Calibration,
    Covariance,
    EstimatorResult,
    Gravity,
    Parameter,
    Residuals,
    Undetermined,
)
from .session import Check, Robot, Session

try:
    __version__ = version("gravcal")
except PackageNotFoundError:
    # Packed into a program, or on a path by itself.
    __version__ = "unknown"

__all__ = [
    "Calibration",
    "Check",
    "Comparison",
    "Covariance",
    "EstimatorResult",
    "GravcalError",
    "Gravity",
    "InputError",
    "Inspection",
    "Observed",
    "Parameter",
    "Poses",
    "Recording",
    "ResidualModel",
    "Residuals",
    "Robot",
    "SensorModel",
    "SensorParameter",
    "Session",
    "Study",
    "Undetermined",
    "apply",
    "compare",
    "export",
    "inspect",
    "read",
    "simulate",
    "study",
]
