"""Learning: gradients through the world, DDPG, critic evaluation."""
