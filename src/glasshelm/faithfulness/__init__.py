"""Are the explanations true? Each is compared with what the pilot does without a ship."""
