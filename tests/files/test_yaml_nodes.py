import math
import time

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.files import yaml_nodes
from tolman.files.messages import FileError
from tolman.files.yaml_nodes import MAX_DEPTH, Entry, parse_yaml


class ShelfError(ValueError):
    pass


def parse(text: str) -> Entry:
    return parse_yaml(text, "f.yaml", ShelfError)


@pytest.fixture(params=["C", "Python"])
def _parser(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "Python":
        monkeypatch.setattr(yaml_nodes, "_loader", lambda yaml: yaml.SafeLoader)


@pytest.mark.usefixtures("_parser")
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: 1\nb: 2\na: 3\n", "f.yaml:3: a: this key appears twice"),
        ("a: {b: 1, b: 2}", "f.yaml:1: a.b: this key appears twice"),
        ("a: &x [1]\nb: *x\n", r"f.yaml:2: b: aliases \(\*x\) are not allowed; write the value out"),
        ("a: &x\n  - {b: *x}\n", r"f.yaml:2: a\[0\].b: aliases"),
        ("a: !!python/object:os.system {}", r"f.yaml:1: a: tags \(tag:yaml.org,2002:python"),
        ("a: ! b", "f.yaml:1: a: tags"),
        ("%YAML 1.1\n---\na: 1\n", "f.yaml:1: directives"),
        ("a: 1\n---\nb: 2\n", "f.yaml:2: a second document"),
        ("? [1, 2]\n: 3\n", "f.yaml:1: a key must be plain text"),
        ("a: [1,\n", "f.yaml:2: not valid YAML"),
        ('a: "\0"', "f.yaml: not valid YAML"),
        ("a: \ud800", "f.yaml: not valid YAML"),
    ],
)
def test_what_is_no_careful_yaml_is_refused_with_its_place(text: str, said: str) -> None:
    with pytest.raises(ShelfError, match=said) as caught:
        parse(text)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    "text",
    [
        "[" * 900_000,
        "- " * 900_000,
        "{a: " * 400_000,
        "".join(" " * depth + "a:\n" for depth in range(1_800)),
        "".join(f"%TAG !a{number}! b\n" for number in range(90_000)) + "--- a",
    ],
    ids=["lists", "dashes", "mappings", "indents", "directives"],
)
def test_bombs_are_refused_at_once(text: str) -> None:
    began = time.process_time()
    with pytest.raises(ShelfError):
        parse(text)
    assert time.process_time() - began < 2.0


def test_size_depth_and_count_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    assert parse("[" * MAX_DEPTH + "]" * MAX_DEPTH).is_list
    with pytest.raises(ShelfError, match=r"f.yaml:1: nested deeper than 64 levels"):
        parse("[" * (MAX_DEPTH + 1) + "]" * (MAX_DEPTH + 1))
    with pytest.raises(FileError, match="nested deeper than 2 levels"):
        parse_yaml("[[[]]]", "f.yaml", depth=2)
    monkeypatch.setattr(yaml_nodes, "MAX_VALUES", 3)
    with pytest.raises(ShelfError, match=r"f.yaml:1: more than 3 values"):
        parse("[1, 2, 3]")
    monkeypatch.setattr(yaml_nodes, "MAX_BYTES", 8)
    with pytest.raises(ShelfError, match="more than the limit of 8"):
        parse("[1, 2, 3]")


@pytest.mark.parametrize("text", ["", "# a remark", "---", "~"])
def test_an_empty_file_is_nothing(text: str) -> None:
    assert parse(text).is_nothing
    with pytest.raises(ShelfError, match=r"f.yaml:[12]: expected a mapping of keys, found nothing"):
        parse(text).mapping()


def test_an_unknown_key_is_named_with_what_was_meant() -> None:
    top = parse("sise: 1\n")
    with pytest.raises(ShelfError, match=r"f.yaml:1: sise: unknown key; did you mean 'size'\?"):
        top.mapping(("size", "angle"))
    with pytest.raises(ShelfError, match=r"f.yaml:1: sise: unknown key; known keys: zzz"):
        top.mapping(("zzz",))
    with pytest.raises(ShelfError, match=r"f.yaml:1: the key 'size' is missing"):
        parse("angle: 1").mapping(("size", "angle"), required=("size",))


@pytest.mark.usefixtures("_parser")
def test_a_fault_names_the_line_of_the_value_and_the_way_to_it() -> None:
    box = parse("boxes:\n  - at: [1, 2]\n    size:\n      - x\n").mapping()["boxes"].items()[0].mapping()
    with pytest.raises(ShelfError, match=r"^f.yaml:4: boxes\[0\].size\[0\]: expected a number, found 'x'$"):
        box["size"].numbers(1)
    with pytest.raises(ShelfError, match=r"^f.yaml:2: boxes\[0\].at: expected 3 values, found 2$"):
        box["at"].numbers(3)


@pytest.mark.usefixtures("_parser")
def test_scalars_are_those_of_the_core_schema() -> None:
    words = "1 -2 1.5 .5 1e3 true False null ~ '' yes on 1:30 2020-13-45 0o17 1_000 '1' \"true\" a"
    assert parse(f"[{', '.join(words.split())}]").data() == [
        *(1, -2, 1.5, 0.5, 1000.0, True, False, None, None, ""),
        *("yes", "on", "1:30", "2020-13-45", "0o17", "1_000", "1", "true", "a"),
    ]


@pytest.mark.parametrize("word", [".nan", ".inf", "-.Inf", "1e999"])
def test_numbers_that_are_not_finite_are_refused(word: str) -> None:
    entry = parse(f"a: {word}").mapping()["a"]
    with pytest.raises(ShelfError, match=r"f.yaml:1: a: "):
        entry.scalar()
    with pytest.raises(ShelfError, match=r"f.yaml:1: a: "):
        entry.number()


@pytest.mark.parametrize("word", ["nan", "infinity", "1_0", "'1'", "true", "", "[1]", "１"])
def test_what_is_no_number_is_none(word: str) -> None:
    with pytest.raises(ShelfError, match="expected a number, found"):
        parse(f"a: {word}").mapping()["a"].number()


def test_numbers_keep_to_their_limits() -> None:
    entry = parse("a: 2.5").mapping()["a"]
    assert entry.number(0.0, 3.0) == 2.5
    with pytest.raises(ShelfError, match=r"2.5 is outside 0 to 1"):
        entry.number(0.0, 1.0)
    with pytest.raises(ShelfError, match=r"2.5 is not a whole number"):
        entry.integer(0, 3)


def test_words_and_flags() -> None:
    keys = parse("a: rigt\nb: true\nc: yes\nd: 5\ne:\n").mapping()
    with pytest.raises(ShelfError, match=r"'rigt' is none of right, left; did you mean 'right'\?"):
        keys["a"].one_of(("right", "left"))
    assert keys["b"].flag()
    with pytest.raises(ShelfError, match="expected true or false, found 'yes'"):
        keys["c"].flag()
    assert keys["d"].text() == "5"
    assert keys["e"].is_nothing
    with pytest.raises(ShelfError, match="expected text, found nothing"):
        keys["e"].text()


def test_a_text_may_stand_for_another() -> None:
    steps = parse("steps:\n  - go_to: $node\n  - say: at $node\n").mapping()["steps"]
    copy = steps.substituted("$node", "3")
    assert copy.data() == [{"go_to": 3}, {"say": "at 3"}]
    assert steps.data() == [{"go_to": "$node"}, {"say": "at $node"}]
    assert copy.items()[1].mapping()["say"].key == "steps[1].say"


def test_errors_show_no_control_characters() -> None:
    entry = parse('a: "b\\a"').mapping()["a"]
    for read in (entry.text, entry.scalar, entry.data):
        with pytest.raises(ShelfError, match=r"f.yaml:1: a: 'b\\x07' holds control characters"):
            read()
    with pytest.raises(ShelfError, match=r"f.yaml:1: a: expected a number, found 'b\\x07'"):
        entry.number()
    with pytest.raises(ShelfError, match=r"f.yaml:1: a key must be plain text"):
        parse('"a\\e[31m": 1')
    assert parse('"line\\nbreak\\t"').text() == "line\nbreak\t"


def test_reading_takes_no_longer_than_composing() -> None:
    text = "boxes:\n" + "".join(
        f"  - {{at: [{i}, 2], size: [0.1, 0.1], angle: {i % 90}}}\n" for i in range(5_000)
    )
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    composing, reading = math.inf, math.inf
    for _ in range(3):
        began = time.process_time()
        yaml.compose(text, Loader=loader)
        composing = min(composing, time.process_time() - began)
        began = time.process_time()
        parse(text)
        reading = min(reading, time.process_time() - began)
    assert reading < 2.0 * composing


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet=st.sampled_from("ab1. :-[]{},&*!%#|>'\"\n\t?~\\\0\x85"), max_size=60))
def test_any_text_is_read_or_refused_in_one_line(text: str) -> None:
    said = ""
    try:
        parse(text).data()
    except ShelfError as error:
        said = str(error)
    assert said.isprintable()
