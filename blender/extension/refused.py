"""What is said where something cannot be."""


class Refused(Exception):
    """What cannot be simulated: the object, by its full name, if it is one's fault; what it was, and what would do."""

    def __init__(self, message, name=None):
        super().__init__(message)
        self.name = name
