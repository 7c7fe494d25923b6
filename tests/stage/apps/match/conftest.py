"""What players can do, made once."""

from __future__ import annotations

import pytest

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.scene.build import prepare_scene
from mgjax.stage.apps.match.pitch import pitch


@pytest.fixture(scope="package")
def moves() -> Repertoire:
    return prepare_scene(pitch(3, net=True))
