from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest
from tolman.plugins import DuplicatePluginError, PluginError
from tolman.plugins.template import write_plugin


def run_test(path: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", str(path.parent)]
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST")}
    return subprocess.run([*command, str(path)], capture_output=True, text=True, check=False, env=environment)


def test_a_new_plugins_test_passes_at_once_and_fails_when_its_body_is_emptied(tmp_path: Path) -> None:
    behavior, test = write_plugin("turn-back", tmp_path / "mine")
    done = run_test(test)
    assert done.returncode == 0, done.stdout
    tree = ast.parse(behavior.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.name in ("ahead", "turning"):
            node.body = [node.body[0], ast.Return(ast.Constant(None))]
    behavior.write_text(ast.unparse(ast.fix_missing_locations(tree)))
    done = run_test(test)
    assert done.returncode == 1
    assert "3 failed" in done.stdout


@pytest.mark.parametrize("name", ["Turn", "turn back", "../turn", "", "class", "turn_back", "-a"])
def test_a_name_that_cannot_be_one_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(PluginError, match="cannot name a behavior"):
        write_plugin(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_taken_name_or_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DuplicatePluginError, match="a behavior named 'wander' already"):
        write_plugin("wander", tmp_path)
    write_plugin("turn-back", tmp_path)
    with pytest.raises(DuplicatePluginError, match="exists"):
        write_plugin("turn-back", tmp_path)


def test_a_package_of_python_is_no_folder_for_plugins(tmp_path: Path) -> None:
    (tmp_path / "__init__.py").touch()
    with pytest.raises(PluginError, match=r"is a Python package.*--folder"):
        write_plugin("turn-back", tmp_path)
