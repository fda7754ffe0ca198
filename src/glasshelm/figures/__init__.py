"""Figures from frames: the paper's 7-11 and 13-15, and what a navigator asks for beside them.

Every figure is a function of a list of :class:`glasshelm.frames.schema.Frame` (or of the
:class:`~glasshelm.frames.series.Series` made from one). Inputs are SI; what is drawn is
in nautical miles, knots, degrees and minutes.
"""
