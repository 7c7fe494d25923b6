"""The command line: ``mgjax --help`` lists its commands."""

from mgjax.cli.main import main as main
