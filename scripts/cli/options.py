"""Argument types and option groups that several commands share."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from ...world.robot import Pose, wrap_angle
from ..errors import UsageError, did_you_mean

if TYPE_CHECKING:
    from ..session.requests import RunSettings

R = TypeVar("R", bound="RunSettings")
NOISES = ("none", "encoder", "thesis")
PROFILES = ("default", "thesis")
LINKS = ("ideal", "calm", "published")
_ONLY_SIMULATED = {
    "resume": "a robot behind a link cannot be put back to where it was",
    "record": "what came over a link cannot be replayed yet",
    "start": "carry the robot to where it is to begin",
    "live": "its page shows true poses, which nobody knows",
    "at": "say by --from at which node it stands, or --lost",
}
PICTURES = (".png", ".svg", ".pdf")


def one_of(*known: str) -> Callable[[str], str]:
    """An argument type that takes one of the known names and suggests the nearest to any other."""

    def convert(text: str) -> str:
        if text not in known:
            raise argparse.ArgumentTypeError(
                f"{text!r} is none of {', '.join(known)}{did_you_mean(text, known)}"
            )
        return text

    return convert


def number(least: float, *, strictly: bool = False) -> Callable[[str], float]:
    """An argument type for a finite number not below (or, strictly, above) `least`."""

    def convert(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
        if not math.isfinite(value) or value < least or (strictly and value == least):
            raise argparse.ArgumentTypeError(f"{text} is not a number {'>' if strictly else '>='} {least:g}")
        return value

    return convert


def integer(least: int, most: int = 2**63 - 1) -> Callable[[str], int]:
    """An argument type for a whole number in [least, most]."""

    def convert(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{value} is not in {least}..{most}")
        return value

    return convert


def pose(text: str) -> Pose:
    """A pose from `X,Y,HEADING`: m, m and degrees, world frame, counter-clockwise from the x axis."""
    try:
        x, y, heading = (float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not X,Y,HEADING (m, m, degrees), as in 0.5,0.057,90"
        ) from None
    if not all(map(math.isfinite, (x, y, heading))):
        raise argparse.ArgumentTypeError(f"{text!r} is not finite")
    return Pose(x, y, wrap_angle(math.radians(heading)))


def node(text: str) -> int | str:
    """A node's number, or its name when it is not a number."""
    try:
        return int(text)
    except ValueError:
        return text


def picture(text: str) -> Path:
    """The path of a picture to write; its suffix says the format."""
    path = Path(text)
    if path.suffix.lower() not in PICTURES:
        raise argparse.ArgumentTypeError(f"{text!r} does not end in {', '.join(PICTURES)}")
    return path


def add_json(parser: argparse.ArgumentParser) -> None:
    """Adds --json."""
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object on stdout, and nothing else there"
    )


def add_force(parser: argparse.ArgumentParser) -> None:
    """Adds --force."""
    parser.add_argument("--force", action="store_true", help="replace an existing output file")


def add_scale(parser: argparse._ActionsContainer) -> None:
    """Adds --scale."""
    parser.add_argument(
        "--scale",
        type=number(0, strictly=True),
        default=1.0,
        metavar="X",
        help="multiply the lengths of a world from a file: many ROS maps are too large for an e-puck",
    )


def add_simulation(parser: argparse.ArgumentParser) -> None:
    """Adds the options common to every command that simulates."""
    group = parser.add_argument_group("simulation")
    group.add_argument(
        "--seed",
        type=integer(0),
        default=0,
        metavar="N",
        help="what all randomness follows from; the same seed gives the same run (default 0)",
    )
    noise = "none: ideal sensors; encoder: wheel steps +-10 %%; thesis: also unequal wheels (default)"
    group.add_argument("--noise", type=one_of(*NOISES), default="thesis", metavar="PRESET", help=noise)
    group.add_argument(
        "--noise-scale",
        type=number(0.0),
        default=1.0,
        metavar="X",
        help="multiplies the preset's noise (default 1)",
    )
    profile = "default: our method; thesis: the published one, faults included"
    group.add_argument("--profile", type=one_of(*PROFILES), default="default", metavar="NAME", help=profile)
    group.add_argument(
        "--robot-model",
        type=one_of("wheels", "planar"),
        dest="model",
        default="wheels",
        metavar="MODEL",
        help="wheels: every wheel simulated (default); planar: a sliding disc, cheaper",
    )
    group.add_argument(
        "--config", type=Path, metavar="FILE", help="YAML file of settings that override the profile's"
    )
    group.add_argument(
        "--plugins",
        type=Path,
        action="append",
        default=[],
        metavar="DIR",
        help="folder whose .py files hold further behaviors (may be given more than once)",
    )
    group.add_argument(
        "--isolate", action="store_true", help="run the behaviors of --plugins in subprocesses"
    )
    add_scale(group)
    add_json(parser)


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Adds the options for robots behind a link."""
    group = parser.add_argument_group("robot behind a link (docs/robots.md)")
    either = group.add_mutually_exclusive_group()
    either.add_argument(
        "--robot",
        metavar="ADDRESS",
        help="drive the e-puck2 at tcp://HOST:PORT, or what speaks its protocol; nothing is simulated",
    )
    either.add_argument(
        "--link",
        type=one_of(*LINKS),
        metavar="NAME",
        help="drive the simulated robot over a modelled radio link: ideal, calm or published (with stalls)",
    )
    group.add_argument(
        "--calibration", type=Path, metavar="FILE", help="what `tolman calibrate` measured of that robot"
    )


def check_robot(options: argparse.Namespace) -> None:
    """Raises: UsageError for options that do not go together with those that `add_robot` adds."""
    if options.calibration is not None and not (options.robot or options.link):
        raise UsageError("--calibration is for a robot behind a link: give --robot or --link too")
    for by, excluded in (("robot", tuple(_ONLY_SIMULATED)), ("link", ("resume", "record"))):
        for name in excluded if getattr(options, by) else ():
            value = getattr(options, name, None)
            if value is not None and value is not False:  # a port may be 0
                raise UsageError(f"--{by} and --{name} do not go together: {_ONLY_SIMULATED[name]}")


def request_of(kind: type[R], options: argparse.Namespace) -> R:
    """The request that a command line makes: its options are named as the fields that they set."""
    values = {name: value for name, value in vars(options).items() if name in kind.__dataclass_fields__}
    return kind(**values | {"plugins": tuple(options.plugins)})
