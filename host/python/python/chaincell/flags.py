"""What is said of a tick, as sums of bits."""

from enum import IntFlag


class Flags(IntFlag):
    """What bit during a tick."""

    MOTION_CLAMPED = 1
    """The tool's motion was shortened."""
    BAD_SAMPLE = 2
    """A bad pose: the last good one stands in, or the safe state is on."""
    STALE = 4
    """No pose within the watchdog's time."""
    FORCE_CLAMPED = 8
    """The force was shortened to its limit."""
    SAFE_STATE = 16
    """The force is 0, and no cell moves."""
    BAND_CLOSED = 32
    """The bands of the links are closed."""
    ROLLED_BACK = 64
    """A pass was discarded by the energy guard."""
    CONTACT_CAPACITY = 128
    """More contacts than there is room for."""
    LATE = 256
    """A newer pose waited: no sweep was made, and the force is that of an earlier tick."""
    RELEASE_FIRST = 512
    """The tool counts as not engaged until a pose has released it."""
    FORCE_WITHHELD = 1024
    """The output stage lets the force go."""
    STARTS_INSIDE = 2048
    """The tool was engaged inside the tissue: no force until it has been outside once."""


class Notes(IntFlag):
    """What the client says of an answer itself."""

    NOTHING_YET = 1
    """No answer has come yet."""
    SILENT = 2
    """No answer for the watchdog's time: the force falls, or is 0."""
    RAMP = 4
    """The force is on a ramp, and not yet that of the tissue."""
    NEW_SESSION = 8
    """The server is another one than before: release each tool once."""
