"""How the run ends early."""


class Stop(Exception):
    """Ends the run with a message and a status."""

    def __init__(self, message: str, status: int = 3):
        super().__init__(message)
        self.status = status
