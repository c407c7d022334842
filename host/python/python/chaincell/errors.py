"""What the package raises. Arguments of a wrong type raise Python's own TypeError."""


class Error(Exception):
    """Any error of the package."""


class ArgumentError(Error, ValueError):
    """A value out of its range, an array of a wrong shape, an option that does not go with the rest."""


class ModelError(Error, ValueError):
    """A mesh or a model file that is none, or what a bake may not choose."""


class SnapshotError(Error, ValueError):
    """A snapshot that is damaged, or belongs to another model or other options."""


class PoseError(Error, ValueError):
    """A pose that is no pose. Nothing was sent, and no tick was made."""


class Refused(Error):
    """A command that was not carried out, with the reason. Nothing has changed."""


class SessionError(Error):
    """Something about a scene or the shared memory of one."""


class NoServer(SessionError):
    """No server on the scene, or none that answers any more."""


class OtherVersion(SessionError):
    """The scene speaks messages of another release."""


class Taken(SessionError):
    """The scene has a controller already."""


class Full(SessionError):
    """As many programs as can be have joined the scene."""


class NoPermission(SessionError):
    """The scene belongs to another user."""


class NoReply(SessionError):
    """No reply to a command in its time. Whether it was carried out is not known."""


class Closed(SessionError):
    """The session was closed, or belongs to the process that this one was forked from."""
