"""Soft tissue for skinned avatars. SI units: m, kg, s, N, J, rad.

An Avatar is baked once and does not change; a Simulation moves it. Arrays are numpy's, float64.
"""

from ._errors import (
    Error,
    FileError,
    FormatError,
    GpuError,
    InvalidError,
    MissingFileError,
    NotFiniteError,
    SolveError,
)
from ._supple import (
    BAKE_PHASES,
    Avatar,
    Clip,
    Collider,
    Potential,
    Simulation,
    StepResult,
    __version__,
)

__all__ = [
    "BAKE_PHASES",
    "Avatar",
    "Clip",
    "Collider",
    "Error",
    "FileError",
    "FormatError",
    "GpuError",
    "InvalidError",
    "MissingFileError",
    "NotFiniteError",
    "Potential",
    "Simulation",
    "SolveError",
    "StepResult",
    "__version__",
]
