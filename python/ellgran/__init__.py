# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contact forces between viscoelastic ellipsoids."""

__version__ = "0.1.0"
