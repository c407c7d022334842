"""Flags and notes of a tick, sums of bits. Written from the tables of the kernel and the client: change them
there."""

from enum import IntFlag


class Flags(IntFlag):
    """Limits and faults that acted during a tick."""

    MOTION_CLAMPED = 1
    """The step limit or the energy limit shortened the tool's motion or the change of its current."""
    BAD_SAMPLE = 2
    """A bad sample, no number or farther than a hand moves: the last good one is used, or the safe
    state is on."""
    STALE = 4
    """No sample within the watchdog's time (set by the output stage or the calling process)."""
    FORCE_CLAMPED = 8
    """Force or torque was clamped to its limit."""
    SAFE_STATE = 16
    """Safe state: the force is zero."""
    BAND_CLOSED = 32
    """The links' bands are closed (unloading)."""
    ROLLED_BACK = 64
    """The energy guard discarded a pass."""
    CONTACT_CAPACITY = 128
    """More triangles are in reach of the tools, or more samples in contact, than the tissue has memory
    for: the farthest ones are left out."""
    LATE = 256
    """The sample was late, as newer ones waited or the tissue cannot keep up: it was executed without a
    sweep, and the force is that of an earlier tick."""
    RELEASE_FIRST = 512
    """The tool counts as not engaged until it has been released once (set by the calling process)."""
    FORCE_WITHHELD = 1024
    """The output stage lowers the force along its ramp or holds it back: passivity control cannot
    compensate the energy that sampling and delay generate, or the hand has put in too little energy."""
    STARTS_INSIDE = 2048
    """A tool engaged inside the tissue, or the tissue closed over it while it grew: it has no contact and
    no force until it has been outside once."""


class Notes(IntFlag):
    """Notes of the client itself on an answer."""

    NOTHING_YET = 1
    """No answer has come yet."""
    SILENT = 2
    """No answer for the time of the watchdog: the force falls, or is 0."""
    RAMP = 4
    """The force is on a ramp, and not yet the force of the tissue."""
    NEW_SESSION = 8
    """A new session has answered, of another server: its tissue is at rest, or where `serve --restore` or
    `serve --stand-by` took it up. Tools get no force until they were released. The note stays until the first
    answer in which no tool must be released."""
