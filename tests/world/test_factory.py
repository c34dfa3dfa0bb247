from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest
from tolman.world import WorldError, open_world


def test_importing_the_package_loads_no_engine() -> None:
    code = (
        "import sys, tolman.world as world; world.open_world('env1', engine='kinematic').step(); "
        "print(sorted({'dartpy', 'embreex', 'matplotlib'} & set(sys.modules)))"
    )
    bare = (
        "import sys, tolman.world; "
        "print(sorted({'dartpy', 'embreex', 'matplotlib', 'yaml'} & set(sys.modules)))"
    )
    for program in (code, bare):
        result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
        assert result.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "options", [{"model": "legs"}, {"engine": "ode"}, {"rays": "gpu"}, {"start": "middle"}, {"seed": -1}]
)
def test_a_wrong_option_is_explained(options: dict[str, Any]) -> None:
    with pytest.raises(WorldError):
        open_world("env1", **{"engine": "kinematic", **options})
