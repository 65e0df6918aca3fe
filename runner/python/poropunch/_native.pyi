from typing import Any, Optional

import numpy as np
import numpy.typing as npt

def protocol(
    name: str, cycles: Optional[int], points: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]: ...
def parameters() -> list[tuple[str, Optional[str], float, Optional[float], Optional[float], list[str], str]]: ...
def simulate(
    library: str,
    time_s: npt.NDArray[np.float64],
    displacement_mm: npt.NDArray[np.float64],
    parameters: dict[str, Any],
    outputs: list[str],
    exact_motion: bool,
) -> dict[str, npt.NDArray[np.float64]]: ...
