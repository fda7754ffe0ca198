"""Training a pilot: DDPG, learning from a planner, critics, trainer, configuration."""
