"""NVIDIA's usd-validation-nvidia finds nothing wrong with what is written."""

import pytest

nvidia = pytest.importorskip("usd_validation_nvidia", reason="no NVIDIA validation: pip install usd-validation-nvidia")


@pytest.mark.parametrize("name", ["crowd.usd", "crowd.expanded.usda"])
def test_no_rule_fails(stones, name):
    issues = nvidia.ValidationEngine().validate(str(stones.crowd_file.with_name(name))).issues()
    failures = [
        (issue.rule.__name__, issue.message) for issue in issues if issue.severity != nvidia.IssueSeverity.WARNING
    ]
    assert failures == []
