"""The Markov decision process: observation (Eq. 10-12), rewards (16-18), step, target selection."""
