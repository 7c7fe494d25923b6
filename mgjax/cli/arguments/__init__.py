"""The commands and their arguments, with defaults of the configurations: no jax, no numpy."""

from mgjax.cli.arguments.graphs import Bench as Bench
from mgjax.cli.arguments.graphs import Build as Build
from mgjax.cli.arguments.graphs import Coverage as Coverage
from mgjax.cli.arguments.motions import Convert as Convert
from mgjax.cli.arguments.motions import Fetch as Fetch
from mgjax.cli.arguments.motions import Info as Info
from mgjax.cli.arguments.motions import Quality as Quality
from mgjax.cli.arguments.rooms import Avoid as Avoid
from mgjax.cli.arguments.rooms import Demo as Demo
from mgjax.cli.arguments.rooms import Scene as Scene
from mgjax.cli.arguments.rooms import Walk as Walk
from mgjax.cli.arguments.runs import CompareRuns as CompareRuns
from mgjax.cli.arguments.runs import ListRuns as ListRuns
from mgjax.cli.arguments.runs import Runs as Runs
from mgjax.cli.arguments.runs import ShowRun as ShowRun
from mgjax.cli.arguments.sensor import Listen as Listen
from mgjax.cli.arguments.sensor import Replay as Replay
from mgjax.cli.arguments.sensor import Send as Send
from mgjax.cli.arguments.sensor import Sensor as Sensor
from mgjax.cli.arguments.shared import KnownReading as KnownReading
from mgjax.cli.arguments.shared import Output as Output
from mgjax.cli.arguments.shared import Reading as Reading
from mgjax.cli.arguments.study import Export as Export
from mgjax.cli.arguments.study import Score as Score
from mgjax.cli.arguments.study import Study as Study
from mgjax.cli.arguments.view import View as View
