"""Training a pilot: DDPG, imitation of an expert, critics, trainer, configuration."""
