import pytest
from tests.missing import missing, needed


@pytest.mark.parametrize("value", [None, "", "false", "0"])
def test_at_a_desk_it_is_a_skip(value, monkeypatch):
    if value is None:
        monkeypatch.delenv("CI", raising=False)
    else:
        monkeypatch.setenv("CI", value)
    with pytest.raises(pytest.skip.Exception, match="no browser"):
        missing("no browser")


@pytest.mark.parametrize("value", ["true", "1", "woodpecker"])
def test_in_ci_it_is_a_failure(value, monkeypatch):
    monkeypatch.setenv("CI", value)
    with pytest.raises(pytest.fail.Exception, match="missing in CI: no browser"):
        missing("no browser")
    with pytest.raises(pytest.fail.Exception, match="no_such_module is not installed"):
        needed("no_such_module")
    assert needed("json").loads("1") == 1
