"""What a user sees while a training runs: a progress bar on a terminal, lines elsewhere."""

from typing import Any

from rich.progress import MofNCompleteColumn, TextColumn, TimeElapsedColumn

from glasshelm.core.terminal import Terminal, progress


class TrainingProgress:
    """A bar for the stage that runs, and one line for each validation."""

    def __init__(self, console: Terminal):
        self.console = console
        figures = TextColumn("{task.fields[figures]}")
        columns = MofNCompleteColumn(), figures, TimeElapsedColumn()
        self._bar = progress(console, *columns)
        self._task = self._bar.add_task("", total=None, figures="")

    def __enter__(self) -> "TrainingProgress":
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def start_stage(self, name: str, unit: str, total: int, completed: int) -> None:
        """A stage starts, or goes on from ``completed`` units."""
        self._bar.reset(
            self._task, description=f"{name} ({unit})", total=total, completed=completed, figures=""
        )

    def advance(self, completed: int) -> None:
        """So many units of the stage are done."""
        self._bar.update(self._task, completed=completed)

    def show(self, line: dict[str, Any]) -> None:
        """The figures that matter of one line of the log."""
        figures = (
            f"return {line['return_waypoint'] + line['return_collision']:.1f}  "
            f"intrusions {line['intrusions']:.1%} / {line['intrusions_long']:.1%}  "
            f"collisions {line['collisions']:.1%} / {line['collisions_long']:.1%}  "
            f"{line['updates_per_s']:.1f} updates/s"
        )
        self._bar.update(self._task, figures=figures)
        parts = [f"{line['stage']} {line['number']}", f"{line['seconds']:.0f} s", figures]
        parts.append(f"rudder {line['rudder']:.2f}")
        if "waypoint_correlation" in line:
            parts.append(
                f"r of Q and return: waypoint {line['waypoint_correlation']:.2f}, "
                f"collision {line['collision_correlation']:.2f}"
            )
        self.console.say("  ".join(parts))
