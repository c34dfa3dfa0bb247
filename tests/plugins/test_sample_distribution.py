from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SAMPLE = Path(__file__).parents[2] / "docs" / "sample-plugin"


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """An environment in which the sample distribution is installed."""
    folder = tmp_path_factory.mktemp("sample")
    source = shutil.copytree(SAMPLE, folder / "source")
    site = folder / "site"
    install = [
        "-m",
        "pip",
        "install",
        "--no-deps",
        "--no-build-isolation",
        "--target",
        str(site),
        str(source),
    ]
    command = [sys.executable, *install]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    values = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST")}
    return values | {"PYTHONPATH": str(site)}


def run(arguments: list[str], environment: dict[str, str]) -> str:
    command = [sys.executable, "-m", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.e2e
def test_an_installed_distributions_behavior_and_mediator_are_found(environment: dict[str, str]) -> None:
    found = json.loads(run(["tolman.scripts.cli", "plugins", "--json"], environment))
    spiral = next(entry for entry in found["behaviors"] if entry["name"] == "spiral")
    assert spiral["origin"] == "tolman-sample-plugin (tolman_sample_plugin.spiral:Spiral)"
    assert "round-robin" in [entry["name"] for entry in found["mediators"]]


@pytest.mark.e2e
def test_its_own_tests_pass_with_the_test_kit(environment: dict[str, str]) -> None:
    assert "3 passed" in run(["pytest", "-q", "-p", "no:cacheprovider", str(SAMPLE / "tests")], environment)


@pytest.mark.e2e
def test_an_installed_behavior_can_run_in_a_subprocess(environment: dict[str, str]) -> None:
    code = (
        "from tolman.plugins import build_behaviors\n"
        "from tolman.plugins.testing import Trial\n"
        "import sys\n"
        "spiral = build_behaviors(['spiral'], configs={'spiral': {'isolate': True}})['spiral']\n"
        "print(Trial(spiral).step().reason, 'tolman_sample_plugin' in sys.modules)"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.strip() == "winding outwards False"
