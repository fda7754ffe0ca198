"""What a person sees while a pilot learns: a bar on a terminal, lines elsewhere."""

from typing import Any

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from glasshelm.core.terminal import TaskDescription, Terminal


class Display:
    """Progress of the stages, and one line an evaluation."""

    def __init__(self, console: Terminal):
        self.console = console
        self._bar = Progress(
            TaskDescription(),
            BarColumn(bar_width=24),
            MofNCompleteColumn(),
            TextColumn("{task.fields[figures]}"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        self._task = None

    def __enter__(self) -> "Display":
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def begin(self, name: str, unit: str, total: int, done: int) -> None:
        """A stage begins, or goes on from ``done``."""
        if self._task is not None:
            self._bar.remove_task(self._task)
        self._task = self._bar.add_task(f"{name} ({unit})", total=total, completed=done, figures="")

    def advance(self, number: int) -> None:
        if self._task is not None:
            self._bar.update(self._task, completed=number)

    def show(self, line: dict[str, Any]) -> None:
        """The figures that matter of one evaluation."""
        figures = (
            f"return {line['return_waypoint'] + line['return_collision']:.1f}  "
            f"intrusions {line['intrusions']:.1%} / {line['intrusions_long']:.1%}  "
            f"collisions {line['collisions']:.1%} / {line['collisions_long']:.1%}  "
            f"{line['updates_per_s']:.1f} updates/s"
        )
        if self._task is not None:
            self._bar.update(self._task, figures=figures)
        parts = [f"{line['stage']} {line['number']}", f"{line['seconds']:.0f} s", figures]
        parts.append(f"rudder {line['rudder']:.2f}")
        if "waypoint_correlation" in line:
            parts.append(
                f"Q agrees: waypoint {line['waypoint_correlation']:.2f}, "
                f"collision {line['collision_correlation']:.2f}"
            )
        self.console.say("  ".join(parts))
