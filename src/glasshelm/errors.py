"""The one exception for what a user gave us and cannot be used."""


class InputError(ValueError):
    """Bad input. The message is one line: what is wrong, where, and what would be right."""
