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
    """Train a pilot and write OUT/best.safetensors and OUT/final.safetensors.

    Ctrl-C stops after a whole step and saves; --resume continues bit for bit.

    Args:
        preset: paper, ddpg, fast, tiny or tiny-fast.
        actor: How the ships are merged into one feature (sum: Eq. 20-21, attention: Eq. 23).
        critic: One TD error of the total (sum, as in the paper) or one for each sub-task (heads).
        ship: Own ship: paper or large_ship.
        seed: Random seed.
        out: Folder for weights, logs and snapshots.
        resume: Continue the training in OUT with its configuration.
        minutes: Stop and save after so many minutes.
        overrides: Any other field of the configuration; may be repeated:
            --set ddpg.batch=512 --set actor_sizes.lens=fine.
            start=FILE begins with the actor of a weights file, start=FILE,FILE,... with the
            mean of several that were trained from one beginning; with imitation.iterations=0
            the preset fast then learns critics for it and nothing else.
        snapshot_s: Seconds between snapshots to resume from.
        tensorboard: Also write TensorBoard logs if tensorboardX is installed.
    """
    import jax

    from glasshelm.core.errors import InputError
    from glasshelm.core.terminal import Terminal
    from glasshelm.ship.nomoto import ship_named
    from glasshelm.training.config import override, preset_named
    from glasshelm.training.trainer import BEST, FINAL, LoopSettings, train
    from glasshelm.training.training_progress import Display
    from glasshelm.training.training_state import read_place

    asked = {"actor": actor, "critic": critic, "ship": ship, "seed": seed}
    asked = {name: value for name, value in asked.items() if value is not None}
    if resume:
        _, config = read_place(out)
        if override(dataclasses.replace(config, **asked), overrides) != config:
            raise InputError(f"{out}: begun with other settings; --resume takes none")
    else:
        config = override(dataclasses.replace(preset_named(preset), **asked), overrides)
    ship_named(config.ship)
    console = Terminal(stderr=False)
    console.say(
        f"{config.preset}: {config.actor} actor, critics by {config.critic}, ship {config.ship}, "
        f"seed {config.seed}, on {jax.devices()[0].device_kind}; writing {out}"
    )
    with Display(console) as display:
        loop = LoopSettings(minutes, snapshot_s, tensorboard)
        whole = train(config, out, loop, resume, display)
    if not whole:
        console.say(f"saved in {out}; go on with: glasshelm train --resume --out {out}")
        raise KeyboardInterrupt
    console.say(f"pilots: {out / BEST} and {out / FINAL}")
