"""The decision process: domain, observation, rewards, step."""
