"""Kernels for every number of joints, compiled: a minute each."""

from __future__ import annotations

import pytest
from test_kernel import check_few_joints

pytestmark = pytest.mark.timeout(1800)


@pytest.mark.parametrize("joints", ["R", "YP", "RPP", "YPPY", "YPPYP"])
def test_arms_of_few_joints_compiled(joints: str) -> None:
    """Kernel and reference engine agree."""
    check_few_joints(joints)
