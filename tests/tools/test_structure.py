"""The house is as it should be: rooms small enough, imports one way, chains short."""

from pathlib import Path

from tools.structure import MOST_CHAIN, MOST_MODULES, House


def written(root: Path, files: dict[str, str]) -> House:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return House.read(root)


def test_a_chain_is_counted_by_what_is_loaded(tmp_path: Path) -> None:
    house = written(
        tmp_path,
        {
            "world/a.py": "from .b import x\n",
            "world/b.py": "from . import c\ndef f():\n    from .d import y\n",
            "world/c.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from .d import y\n",
            "world/d.py": "y = 1\n",
        },
    )
    assert house.chain == ("world.a", "world.b", "world.c")
    assert house.all["world.c"] == {"world.d"}


def test_circles_are_found_also_where_only_a_type_checker_sees_them(tmp_path: Path) -> None:
    lazy = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ..one.a import x\n"
    house = written(tmp_path, {"maps/one/a.py": "from ..two.b import y\n", "maps/two/b.py": lazy})
    assert house.circles() == [("maps.one.a", "maps.two.b")]
    assert house.circles(rooms=True) == [("maps.one", "maps.two")]


def test_no_folder_has_too_many_modules() -> None:
    widths = House.read().widths()
    assert {folder for folder, modules in widths.items() if modules > MOST_MODULES} == set()


def test_no_chain_of_imports_is_too_long_and_none_is_a_circle() -> None:
    house = House.read()
    assert len(house.chain) <= MOST_CHAIN, " > ".join(house.chain)
    assert house.circles() == []
