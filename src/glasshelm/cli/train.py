"""``glasshelm train``: train a pilot."""

import dataclasses
from pathlib import Path
from typing import Annotated, Literal

import tyro


def run(
    preset: str = "fast",
    actor: Literal["sum", "attention"] | None = None,
    critic: Literal["sum", "heads"] | None = None,
    ship: str | None = None,
    seed: int | None = None,
    out: Path = Path("runs/pilot"),
    resume: bool = False,
    minutes: float | None = None,
    overrides: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(name="set", metavar="FIELD=VALUE")
    ] = (),
    snapshot_s: float = 60.0,
    tensorboard: bool = True,
) -> None:
    """Train a pilot and write it to OUT/best.safetensors and OUT/final.safetensors.

    Ctrl-C stops at a whole step and saves; --resume continues from there, bit for bit.

    Args:
        preset: paper, ddpg, fast, glassbox, course, or tiny and its like.
        actor: How the ships are merged into one feature (sum: Eq. 20-21, attention: Eq. 23).
        critic: One TD error of the total (the paper), or one for each sub-task.
        ship: Own ship: paper or large_ship.
        seed: Random seed.
        out: Folder for weights, logs and snapshots.
        resume: Continue the training in OUT, with the configuration it started with.
        minutes: Stop cleanly after this many minutes.
        overrides: Any other field of the configuration; may be repeated:
            --set ddpg.batch_size=512 --set actor_sizes.lens=fine.
            init_from=FILE starts from the actor of a weights file, init_from=FILE,FILE,...
            from the mean of several that were trained from the same start; with
            dagger.iterations=0 the preset fast then trains critics for it and nothing else.
        snapshot_s: Seconds between two snapshots to resume from.
        tensorboard: Also write TensorBoard logs if tensorboardX is installed.
    """
    import jax

    from glasshelm.core.errors import InputError
    from glasshelm.core.terminal import Terminal
    from glasshelm.ship.nomoto import ship_named
    from glasshelm.training.config import preset_named, with_settings
    from glasshelm.training.trainer import BEST_FILE, FINAL_FILE, TrainerSettings, train
    from glasshelm.training.training_progress import TrainingProgress
    from glasshelm.training.training_state import read_position

    options = {"actor": actor, "critic": critic, "ship": ship, "seed": seed}
    options = {name: value for name, value in options.items() if value is not None}
    if resume:
        _, config = read_position(out)
        if with_settings(dataclasses.replace(config, **options), overrides) != config:
            raise InputError(f"{out}: started with other settings; --resume takes none")
    else:
        config = with_settings(dataclasses.replace(preset_named(preset), **options), overrides)
    ship_named(config.ship)
    console = Terminal(stderr=False)
    what = f"{config.actor} actor, critics by {config.critic}"
    if config.algorithm in ("regression", "course"):
        what = "a critic of manoeuvres that steers"
    console.say(
        f"{config.preset}: {what}, ship {config.ship}, "
        f"seed {config.seed}, on {jax.devices()[0].device_kind}; writing {out}"
    )
    with TrainingProgress(console) as progress:
        settings = TrainerSettings(minutes, snapshot_s, tensorboard)
        complete = train(config, out, settings, resume, progress)
    if not complete:
        console.say(f"saved in {out}; continue with: glasshelm train --resume --out {out}")
        raise KeyboardInterrupt
    console.say(f"pilots: {out / BEST_FILE} and {out / FINAL_FILE}")
