"""Ball sport: hit motions found in capture, matched to a live motion, and the ball between players.

After Choi, Kim, Kim and Kang, *Generating a Ball Sport Scene in a Virtual Environment* (2019).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgjax._lazy import attach

if TYPE_CHECKING:
    from mgjax.ballsport.aiming.hit_frame import HitChoice as HitChoice
    from mgjax.ballsport.aiming.hit_frame import choose_frame as choose_frame
    from mgjax.ballsport.aiming.passes import aim as aim
    from mgjax.ballsport.aiming.passes import aim_batch as aim_batch
    from mgjax.ballsport.aiming.solve import Aim as Aim
    from mgjax.ballsport.ball.physics import BallPhysics as BallPhysics
    from mgjax.ballsport.ball.physics import Net as Net
    from mgjax.ballsport.ball.trajectory import ball_states as ball_states
    from mgjax.ballsport.ball.trajectory import contact_times as contact_times
    from mgjax.ballsport.ball.trajectory import fly as fly
    from mgjax.ballsport.clipset.ball_contact import Contacts as Contacts
    from mgjax.ballsport.clipset.build import ClipSet as ClipSet
    from mgjax.ballsport.clipset.build import build_clip_set as build_clip_set
    from mgjax.ballsport.clipset.joining import Joined as Joined
    from mgjax.ballsport.clipset.joining import join as join
    from mgjax.ballsport.clipset.match import Match as Match
    from mgjax.ballsport.clipset.match import Matcher as Matcher
    from mgjax.ballsport.clipset.repertoire import Repertoire as Repertoire
    from mgjax.ballsport.clipset.transition import TransitionTable as TransitionTable
    from mgjax.ballsport.clipset.transition import find_transitions as find_transitions
    from mgjax.ballsport.config import AnalysisConfig as AnalysisConfig
    from mgjax.ballsport.config import ClipSetConfig as ClipSetConfig
    from mgjax.ballsport.config import KindConfig as KindConfig
    from mgjax.ballsport.config import MatchConfig as MatchConfig
    from mgjax.ballsport.config import TransitionConfig as TransitionConfig
    from mgjax.ballsport.hits.bones import BoneHit as BoneHit
    from mgjax.ballsport.hits.bones import LiveAnalysis as LiveAnalysis
    from mgjax.ballsport.hits.bones import analyse as analyse
    from mgjax.ballsport.hits.detect import Hit as Hit
    from mgjax.ballsport.hits.detect import Marks as Marks
    from mgjax.ballsport.hits.detect import find_hits as find_hits
    from mgjax.ballsport.hits.detect import hit_joint as hit_joint
    from mgjax.ballsport.hits.detect import mark as mark
    from mgjax.ballsport.hits.motion_vectors import MotionVectors as MotionVectors
    from mgjax.ballsport.hits.motion_vectors import motion_vector as motion_vector
    from mgjax.ballsport.hits.stream import HitStream as HitStream
    from mgjax.ballsport.live.choice import SensorChoice as SensorChoice
    from mgjax.ballsport.live.open_scene import OpenScene as OpenScene
    from mgjax.ballsport.live.open_scene import ScenePart as ScenePart
    from mgjax.ballsport.live.recogniser import LiveDriver as LiveDriver
    from mgjax.ballsport.live.recogniser import PassDecision as PassDecision
    from mgjax.ballsport.scene.ball_track import BallEvent as BallEvent
    from mgjax.ballsport.scene.ball_track import BallTrack as BallTrack
    from mgjax.ballsport.scene.build import Scene as Scene
    from mgjax.ballsport.scene.build import build_scene as build_scene
    from mgjax.ballsport.scene.build import prepare_scene as prepare_scene
    from mgjax.ballsport.scene.config import Pass as Pass
    from mgjax.ballsport.scene.config import Player as Player
    from mgjax.ballsport.scene.config import SceneConfig as SceneConfig
    from mgjax.ballsport.scene.kick import Kick as Kick
    from mgjax.ballsport.scene.rally import Rally as Rally
    from mgjax.ballsport.scene.types import BallFlight as BallFlight
    from mgjax.ballsport.scene.types import Touch as Touch
    from mgjax.sensor.config import ReplayConfig as ReplayConfig
    from mgjax.sensor.counts import Counts as Counts
    from mgjax.sensor.frames import SensorFrame as SensorFrame
    from mgjax.sensor.receiver import SensorReceiver as SensorReceiver
    from mgjax.sensor.replay import Replayed as Replayed
    from mgjax.sensor.replay import replay as replay
else:
    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "Marks": "mgjax.ballsport.hits.detect",
            "mark": "mgjax.ballsport.hits.detect",
            "hit_joint": "mgjax.ballsport.hits.detect",
            "Aim": "mgjax.ballsport.aiming.solve",
            "aim": "mgjax.ballsport.aiming.passes",
            "aim_batch": "mgjax.ballsport.aiming.passes",
            "analyse": "mgjax.ballsport.hits.bones",
            "AnalysisConfig": "mgjax.ballsport.config",
            "ball_states": "mgjax.ballsport.ball.trajectory",
            "BallPhysics": "mgjax.ballsport.ball.physics",
            "BallTrack": "mgjax.ballsport.scene.ball_track",
            "BoneHit": "mgjax.ballsport.hits.bones",
            "build_clip_set": "mgjax.ballsport.clipset.build",
            "build_scene": "mgjax.ballsport.scene.build",
            "choose_frame": "mgjax.ballsport.aiming.hit_frame",
            "ClipSet": "mgjax.ballsport.clipset.build",
            "ClipSetConfig": "mgjax.ballsport.config",
            "contact_times": "mgjax.ballsport.ball.trajectory",
            "Contacts": "mgjax.ballsport.clipset.ball_contact",
            "Counts": "mgjax.sensor.counts",
            "BallEvent": "mgjax.ballsport.scene.ball_track",
            "find_hits": "mgjax.ballsport.hits.detect",
            "find_transitions": "mgjax.ballsport.clipset.transition",
            "fly": "mgjax.ballsport.ball.trajectory",
            "Hit": "mgjax.ballsport.hits.detect",
            "HitChoice": "mgjax.ballsport.aiming.hit_frame",
            "HitStream": "mgjax.ballsport.hits.stream",
            "join": "mgjax.ballsport.clipset.joining",
            "Joined": "mgjax.ballsport.clipset.joining",
            "Kick": "mgjax.ballsport.scene.kick",
            "KindConfig": "mgjax.ballsport.config",
            "BallFlight": "mgjax.ballsport.scene.types",
            "LiveAnalysis": "mgjax.ballsport.hits.bones",
            "LiveDriver": "mgjax.ballsport.live.recogniser",
            "Match": "mgjax.ballsport.clipset.match",
            "MatchConfig": "mgjax.ballsport.config",
            "Matcher": "mgjax.ballsport.clipset.match",
            "motion_vector": "mgjax.ballsport.hits.motion_vectors",
            "MotionVectors": "mgjax.ballsport.hits.motion_vectors",
            "Net": "mgjax.ballsport.ball.physics",
            "OpenScene": "mgjax.ballsport.live.open_scene",
            "Pass": "mgjax.ballsport.scene.config",
            "PassDecision": "mgjax.ballsport.live.recogniser",
            "Player": "mgjax.ballsport.scene.config",
            "prepare_scene": "mgjax.ballsport.scene.build",
            "Rally": "mgjax.ballsport.scene.rally",
            "Repertoire": "mgjax.ballsport.clipset.repertoire",
            "replay": "mgjax.sensor.replay",
            "ReplayConfig": "mgjax.sensor.config",
            "Replayed": "mgjax.sensor.replay",
            "Scene": "mgjax.ballsport.scene.build",
            "SceneConfig": "mgjax.ballsport.scene.config",
            "ScenePart": "mgjax.ballsport.live.open_scene",
            "SensorChoice": "mgjax.ballsport.live.choice",
            "SensorFrame": "mgjax.sensor.frames",
            "SensorReceiver": "mgjax.sensor.receiver",
            "Touch": "mgjax.ballsport.scene.types",
            "TransitionConfig": "mgjax.ballsport.config",
            "TransitionTable": "mgjax.ballsport.clipset.transition",
        },
    )
