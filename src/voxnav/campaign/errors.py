# SPDX-License-Identifier: BSD-3-Clause
"""The error that ends a campaign before or while it flies."""


class CampaignError(RuntimeError):
    """A campaign cannot be flown or continued; the text says why and what can be done."""
