"""The exceptions of this package. Their messages say what failed, and why."""


class Error(Exception):
    """The base class of the exceptions of this package."""


class MazeError(Error, ValueError):
    """A maze cannot be read, written or found."""


class RecordingError(Error, ValueError):
    """A file is not a recording."""


class Contradiction(Error, ValueError):
    """An observation contradicts the map of a mouse. The map has not changed."""


class SearchError(Error):
    """A strategy cannot continue, for example because the goal is unreachable."""


class SimulatorError(Error):
    """The simulator is not reachable, or its reply is invalid."""


class NoReply(SimulatorError):
    """The simulator did not reply in time. The next request uses a new connection."""


class Refused(SimulatorError, ValueError):
    """The simulator refused the request, which changed nothing. The message says why."""
