"""Counterfactual replay: any instant of any log sailed on, as it was and with something changed."""
