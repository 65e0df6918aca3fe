"""Dataclasses over the JSON of the commands, one module for each and one for what they share, and how to read them."""
