"""Everything that can steer, behind one small interface."""
