import pytest

from glasshelm.paper.kept_results import RECORD_FILE, KeptResults, digest_of


def test_a_result_is_kept_while_what_it_was_made_from_is_the_same(tmp_path):
    file = tmp_path / "figure.svg"
    file.write_text("drawn")
    KeptResults(tmp_path).add("figure", "one")
    again = KeptResults(tmp_path)
    assert again.has("figure", "one", file)
    assert not again.has("figure", "other", file)
    assert not again.has("another", "one", file)
    file.unlink()
    assert not again.has("figure", "one", file)


@pytest.mark.parametrize("text", ["{", "[]", "\xff"])
def test_a_damaged_record_holds_nothing(tmp_path, text):
    (tmp_path / RECORD_FILE).write_text(text, encoding="latin-1")
    assert not KeptResults(tmp_path).has("figure", "one")


def test_parts_are_told_apart():
    assert digest_of("a", "bc") != digest_of("ab", "c")
