"""Globs that users give, and what is said of one that nothing matches."""

from linkwright.stages.robot.text.globs import there_are


def test_a_message_names_what_is_near_and_all_there_is():
    assert there_are("sholder", {"joints": ["wrist", "shoulder"]}) == (
        "did you mean shoulder? joints are: shoulder, wrist"
    )
    known = {"links": ["base"], "parts": ["Bracket", "Block"]}
    assert there_are("Braket", known) == "did you mean Bracket? links are: base; parts are: Block, Bracket"
    assert there_are("wheel*", {"frames": []}) == "frames are: none"
