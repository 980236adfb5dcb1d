"""Gymnasium environments of the emulated robot; importing this package registers them.

Observations are the measurements of the real robot. Ground truth is in `info`, and the rewards are made of it.
"""

from __future__ import annotations

from nao_hil.envs.registration import register_all

register_all()
