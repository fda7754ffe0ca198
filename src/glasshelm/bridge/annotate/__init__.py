"""What is added to a frame: alarms, certified bands, sentence, Rules, what-if answers."""
