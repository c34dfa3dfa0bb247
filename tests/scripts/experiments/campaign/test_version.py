"""Versions of the code: what results depend on, and what they do not."""

from tolman.scripts.experiments.campaign.version import code_version, imported_scripts


def test_the_layout_of_the_report_is_no_part_of_what_results_depend_on() -> None:
    for script in ("experiments.runs.mapping", "experiments.runs.traversal"):
        parts = imported_scripts(script)
        assert {
            "session.mapping",
            "session.stage",
            "session.profiles",
            "session.assembly",
            "session.truth",
            "experiments.runs.probes",
            "experiments.worlds.random_rooms",
        } <= parts
        assert not parts & {
            f"experiments.{name}" for name in ("report.text", "results.tables", "page", "campaign.campaign")
        }
    assert "experiments.runs.traversal" not in imported_scripts("experiments.runs.mapping")
    assert code_version() != code_version("experiments.runs.traversal")
