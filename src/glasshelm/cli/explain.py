"""``glasshelm explain``: simulate an encounter, or read a log, and explain it."""

from pathlib import Path
from typing import Annotated

import tyro

from glasshelm.cli.voyage_options import Voyage, logged_frames


def run(
    voyage: Voyage,
    out: Path = Path("explained"),
    open_: Annotated[bool, tyro.conf.arg(name="open")] = False,
) -> None:
    """Simulate an encounter and explain it: frames.jsonl, figures and report.html.

    The figures are those of the paper (7-11, 13-15) and some more, each as PDF and PNG. A log of
    an earlier voyage (a .jsonl file) is not simulated again. Ctrl-C stops the simulation; the
    frames written so far stay readable.

    Args:
        voyage: The encounter and its pilot.
        out: Folder for frames, figures and report; existing files are replaced.
        open_: Open the report in the browser.
    """
    from glasshelm.certify.logged_measurements import with_bands
    from glasshelm.certify.sensor_error_bounds import parse_error_bounds
    from glasshelm.core.errors import InputError
    from glasshelm.core.output_dir import writable_folder
    from glasshelm.core.terminal import Terminal, print_result, progress
    from glasshelm.frames.frame_log import FrameLog
    from glasshelm.report.narrative import narrate
    from glasshelm.report.passages import verdict
    from glasshelm.report.write_report import write_report
    from glasshelm.whatif.logged_world import pilot_of

    console = Terminal()
    writable_folder(out)
    title, notes = None, ()
    if voyage.source.endswith(".jsonl"):
        ignored = ("pilot", "ship", "own", "at", "minutes", "advise", "steps")
        if any(getattr(voyage, name) not in (None, False) for name in ignored):
            raise InputError(
                f"{voyage.source}: a log is explained as it is; leave out {', '.join(ignored)}"
            )
        frames = logged_frames(Path(voyage.source))
        if voyage.sensor_errors is not None:
            errors = parse_error_bounds(voyage.sensor_errors)
            frames = list(with_bands(frames, pilot_of(frames[0]), errors))
    else:
        scenario, pilot, count, simulated = voyage.simulate()
        title, notes = f"{scenario.title}, pilot {pilot.name}", scenario.notes
        console.say(title)
        frames = []
        with FrameLog(out / "frames.jsonl", fresh=True) as log, progress(console) as bar:
            task = bar.add_task("simulating", total=count)
            try:
                for frame in simulated:
                    log.write(frame)
                    frames.append(frame)
                    bar.advance(task)
            except KeyboardInterrupt:
                console.say(f"interrupted: {log.frames} frames are in {log.path}")
                raise

    with progress(console) as bar:
        task = bar.add_task("drawing", total=1.0)
        path = write_report(
            frames,
            out,
            title,
            notes,
            progress=lambda name, share: bar.update(task, description=name, completed=share),
        )
    print_result(verdict(frames))
    for sentence in narrate(frames):
        print_result(str(sentence))
    print_result(f"report: {path}")
    if open_:
        import webbrowser

        webbrowser.open(path.resolve().as_uri())
