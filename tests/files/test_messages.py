import pytest
from tolman.files.messages import did_you_mean, nearest, printable, quoted, unknown


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain, ünïcode 漢字", "plain, ünïcode 漢字"),
        ("a\x1b[31m\x07b", "a\\x1b[31m\\x07b"),
        ("line\nbreak\r", "line\\nbreak\\r"),
        ("right\u202eto left", "right\\u202eto left"),
        ("lone \udcff", "lone \\udcff"),
        ("c1 \x9b", "c1 \\x9b"),
        ("no-break\xa0space", "no-break\xa0space"),
    ],
)
def test_what_a_terminal_may_obey_is_escaped(text: str, shown: str) -> None:
    assert printable(text) == shown


def test_line_breaks_can_be_kept() -> None:
    assert printable("a\n\x1bb", keep="\n") == "a\n\\x1bb"


def test_values_are_quoted_escaped_and_cut() -> None:
    assert quoted("a\x1bb") == "'a\\x1bb'"
    assert quoted(["x"]) == "['x']"
    assert len(quoted("x" * 10_000)) < 80
    assert len(quoted(["x"] * 10_000)) < 80


def test_the_nearest_known_name_is_suggested() -> None:
    assert nearest("env11", ["env1", "office"]) == "env1"
    assert nearest("zzz", ["env1", "office"]) is None
    assert did_you_mean("env11", ["env1", "office"]) == "; did you mean 'env1'?"
    assert did_you_mean("zzz", ["env1", "office"]) == ""
    assert unknown("world", "env11", ["env1", "office"]) == (
        "unknown world 'env11'; did you mean 'env1'? known: env1, office"
    )
    assert unknown("world", "a\nb", []) == "unknown world 'a\\nb'; known: none"


def test_only_the_beginning_of_an_endless_name_is_compared() -> None:
    assert nearest("env1" + "x" * 5_000_000, ["env1"]) is None
