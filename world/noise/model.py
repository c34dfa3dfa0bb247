"""How far sensors and wheels deviate from the ideal: presets as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

from ...files.messages import unknown
from ..errors import WorldError


@dataclass(frozen=True, slots=True)
class Noise:
    """Sizes of all deviations; 0 is ideal.

    encoder: each wheel's counted increment is off by a relative error uniform in +-encoder, drawn every tick.
    mismatch: the true radii are r (1 + e/2) left and r (1 - e/2) right, e uniform in +-mismatch, drawn once
    a run, so that their mean is exact; the encoders know nothing of it.
    slip: each wheel moves the robot less than it rotates, by a share uniform in [0, slip], drawn every tick.
    infrared: factor on the relative noise of the sensors' table (1 is the table).
    infrared_floor: standard deviation (raw units) where nothing is in range.
    camera: standard deviation of a pixel's luminance.
    accelerometer: standard deviation (m/s^2) an axis.
    sensors: factor on the noise that any further sensor states for itself (1 is as its maker says).
    unequal_wheels, wrong_track: UMBmark's two systematic errors (Borenstein and Feng 1996), the same in
    every run: right over left true wheel diameter minus 1, and true over nominal track minus 1.
    """

    encoder: float = 0.0
    mismatch: float = 0.0
    slip: float = 0.0
    infrared: float = 0.0
    infrared_floor: float = 0.0
    camera: float = 0.0
    accelerometer: float = 0.0
    unequal_wheels: float = 0.0
    wrong_track: float = 0.0
    sensors: float = 0.0

    def scaled(self, factor: float) -> Noise:
        """Every deviation times `factor`.

        Raises: WorldError unless `factor` is finite and within 0..100, or a result is out of range.
        """
        if not 0.0 <= factor <= 100.0:
            raise WorldError(f"noise scale {factor:g} is outside 0 to 100")
        return checked(Noise(**{name: getattr(self, name) * factor for name in NAMES}))


NAMES = tuple(entry.name for entry in fields(Noise))
_LIMITS = {
    "encoder": (0.0, 1.0),
    "mismatch": (0.0, 0.5),
    "slip": (0.0, 1.0),
    "unequal_wheels": (-0.5, 0.5),
    "wrong_track": (-0.5, 0.5),
}
_ENCODER = Noise(encoder=0.10, infrared=1.0, infrared_floor=5.0, camera=0.01, accelerometer=0.05, sensors=1.0)
PRESETS: Mapping[str, Noise] = {
    "none": Noise(),
    "encoder": _ENCODER,
    "thesis": replace(_ENCODER, mismatch=0.021),
}
"""By name: no noise; the +-10 % that the thesis states; and with the mismatch that its table 4.3 takes."""


def checked(noise: Noise) -> Noise:
    """The noise itself, when every value is within its limits.

    Raises: WorldError naming the value and its limits.
    """
    for name in NAMES:
        low, high = _LIMITS.get(name, (0.0, 1e4))
        value = getattr(noise, name)
        if not low <= value <= high:
            raise WorldError(f"noise {name} {value!r} is outside {low:g} to {high:g}")
    return noise


def resolve_noise(noise: str | Noise | Mapping[str, float | str], scale: float = 1.0) -> Noise:
    """The noise meant by a preset's name, by values, or by a mapping: `preset` (optional) and any values.

    Raises: WorldError for an unknown preset or value, suggesting the nearest.
    """
    if isinstance(noise, Noise):
        return checked(noise).scaled(scale)
    if isinstance(noise, str):
        if noise not in PRESETS:
            raise WorldError(unknown("noise preset", noise, PRESETS))
        return PRESETS[noise].scaled(scale)
    base = resolve_noise(str(noise.get("preset", "none")))
    values: dict[str, float] = {}
    for name, value in noise.items():
        if name == "preset":
            continue
        if name not in NAMES:
            raise WorldError(unknown("noise value", name, NAMES))
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise WorldError(f"noise {name} must be a number, not {value!r}")
        values[name] = float(value)
    return checked(replace(base, **values)).scaled(scale)
