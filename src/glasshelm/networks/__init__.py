"""Networks: actors and sub-task critics for any number of ships."""
