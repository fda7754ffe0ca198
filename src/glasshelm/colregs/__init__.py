"""The COLREGs: kinds of encounter, who gives way, compliance, and the words for it."""
