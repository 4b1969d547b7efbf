"""The state machine of dispatch with many more examples, other ones each time."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, settings
from test_dispatch_machine import AnyOrder

pytestmark = pytest.mark.timeout(900)

_MANY = settings(stateful_step_count=80, derandomize=False, suppress_health_check=list(HealthCheck))


class MoreOrders(AnyOrder):
    """As there."""


MoreOrders.TestCase.settings = settings(_MANY, max_examples=2000)
TestMoreOrders = MoreOrders.TestCase
