"""Dataclasses over the JSON of the commands, one module for each, and how to read them."""
