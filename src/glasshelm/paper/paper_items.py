"""What the paper numbers, and what it says of each in a few words of ours.

Yoshioka and Hashimoto, Explainable AI for Ship Collision Avoidance (arXiv 2405.09081).
"""

import dataclasses

#: The paper's DDPG as trained, and ours: the critics that steer, and attention.
PILOTS = ("paper-sum-ddpg", "paper-glassbox", "paper-attention-ddpg", "paper-attention")
#: The encounter of Figures 10-15: four ships.
ENCOUNTER = "random:210:4"
#: The other encounters of Figures 7-9, of one to six ships; that of Figures 10-15 comes fourth.
OTHERS = ("random:1:1", "random:7:2", "random:12:3", "random:5:5", "random:9:6")


@dataclasses.dataclass(frozen=True)
class PaperEquation:
    """An equation: what it gives, and how it is read here.

    Attributes:
        number: As the paper numbers it.
        gives: What it defines.
        reading: Where the reading differs from the print, and why; empty where it does not.
        code: The module that computes it.
    """

    number: str
    gives: str
    reading: str
    code: str


@dataclasses.dataclass(frozen=True)
class PaperFigure:
    """A figure: what the paper shows in it.

    Attributes:
        number: As the paper numbers it.
        title: What it is about.
        equations: The equations that it rests on.
        says: What the paper shows and concludes, paraphrased.
        made: How it is made here.
    """

    number: str
    title: str
    equations: str
    says: str
    made: str


EQUATIONS = (
    PaperEquation(
        "1", "The discounted return.", "The printed indices repeat; Σ γᵏ r(t+k+1) is meant.",
        "training/critic_accuracy.py",
    ),
    PaperEquation(
        "2", "The critic's loss.",
        "Printed with γ at the wrong Q and a stray minus. Here the mean of (r + γ Q′ − Q)².",
        "training/losses.py",
    ),
    PaperEquation("3", "The actor's loss: minus the mean Q.", "", "training/losses.py"),
    PaperEquation(
        "4", "Target networks follow slowly.",
        "α is called the learning rate; the update rate of Table A.6 is used.",
        "training/ddpg.py",
    ),
    PaperEquation(
        "5", "The actor's loss with regularisation, smoothing and small rudders.",
        "Σ θ² instead of Σ θ: a sum of signed weights regularises nothing.",
        "training/losses.py",
    ),
    PaperEquation(
        "6", "Turning: T dr/dt + r = K δ.",
        "K, T and the integration are not given. Solved exactly over a step.", "ship/nomoto.py",
    ),
    PaperEquation("7", "Position and heading from speed and rate of turn.", "", "ship/nomoto.py"),
    PaperEquation(
        "8", "Where a target starts so that both would collide.", "Own speed is not given: 10 kn.",
        "encounters/random_encounters.py",
    ),
    PaperEquation(
        "9", "Noise on that start.",
        "Starts nearer than 7 LOA or inside the domain are drawn again.",
        "encounters/random_encounters.py",
    ),
    PaperEquation("10", "What is observed of the waypoint.", "In own ship's axes.",
                  "env/observe.py"),
    PaperEquation("11", "What is observed of a target, CPA included.",
                  "In own ship's axes; CPA sought within an hour.", "env/observe.py"),
    PaperEquation(
        "12", "The state: waypoint and all targets, with four past frames.",
        "At the start the first frame is repeated.", "env/observe.py",
    ),
    PaperEquation("13", "The level of danger of a target.",
                  "Clipped at 0, or Eq. 16 could never be 0 outside.", "ship/domain.py"),
    PaperEquation("14-15", "The half axes of the exclusive area.",
                  "Lengths are LOA, 340 m; the print also says lpp.", "ship/domain.py"),
    PaperEquation("16", "The reward for danger: rising danger costs more.", "", "env/rewards.py"),
    PaperEquation("17", "The reward for heading to the waypoint.", "", "env/rewards.py"),
    PaperEquation("18", "The reward for turning to the waypoint in a clear sea.",
                  "Guarded where the bearing before was 0.", "env/rewards.py"),
    PaperEquation("19", "Q as a sum: one critic for the waypoint, one for every ship.", "",
                  "networks/critics.py"),
    PaperEquation("20", "The features: encodings summed, then softsign.", "",
                  "networks/actors.py"),
    PaperEquation("21", "The rudder from the features.",
                  "Printed without the softsign of Eq. 20; used with it.", "networks/actors.py"),
    PaperEquation(
        "22", "Priority of a sub-task: its Q of the choice less its Q of going straight.",
        "Q_wp is printed also for the ships; Q_ca is meant. Of a manoeuvre: less Q of keeping on.",
        "explanation/quantities.py",
    ),
    PaperEquation("23", "Attention: scores of pairs of ships, summed, then softmax.",
                  "The network's sizes are not given: 128-128-1.", "networks/actors.py"),
    PaperEquation(
        "24", "Intention with regard to a ship: Q_ca times attention.",
        "Both readings are drawn: the increment of Q_ca (the journal's, the default) and Q_ca "
        "itself (the preprint's).",
        "explanation/quantities.py",
    ),
)  # fmt: skip

_ONE = "One encounter of four ships, the same in Figures 10 to 15."

FIGURES = {
    figure.number: figure
    for figure in (
        PaperFigure(
            "1", "Coordinates of ship motion", "6-7",
            "Defines axes, heading and rate of turn. The rudder is limited to 5° a side.",
            "Axes and hull to scale; on the right both ship presets with the rudder hard over. "
            "The paper gives no K and T. Those of the preset paper turn faster than any ship of "
            "340 m, and those of large_ship do not.",
        ),
        PaperFigure(
            "2", "Initial state of the other ships", "8-9",
            "A target is put where it would collide with own ship after 600 to 1800 s, then moved "
            "and turned at random.",
            "The construction for one target with the settings' mean values, and starts drawn by "
            "the simulator.",
        ),
        PaperFigure(
            "3", "Closest point of approach", "11",
            "Defines CPA, DCPA and TCPA for two ships that keep straight on.",
            "An example with CPA, DCPA and TCPA as the observation computes them.",
        ),
        PaperFigure(
            "4", "The exclusive area", "13-15",
            "Four quarter ellipses, longest ahead, twice as wide to starboard as to port.",
            "The area and Eq. 13 inside it, evaluated from the code.",
        ),
        PaperFigure(
            "5", "The critic", "19",
            "Every sub-task has a critic of its own, and their outputs are summed, so each part "
            "of Q depends only on its own input.",
            "Widths are read from the weight matrices of the preset paper.",
        ),
        PaperFigure(
            "6", "The actor", "20-21",
            "Encodings of waypoint and ships are summed, so any number of ships fits.",
            "Widths are read from the weight matrices of the preset paper.",
        ),
        PaperFigure(
            "7", "Trajectories", "6-18",
            "In all encounters shown, no ship enters the exclusive area: safe avoidance has been "
            "learned.",
            "Six encounters of one to six ships, 1200 s each, the same for every pilot; the fourth "
            "is that of Figures 10 to 15. Own ship's markers are open.",
        ),
        PaperFigure(
            "8", "Relative trajectories", "13-15",
            "Seen from own ship, tracks pass around the exclusive area.",
            "The same voyages in own ship's axes, with the area to scale.",
        ),
        PaperFigure(
            "9", "The critic's view of every ship", "19",
            "Tracks are coloured by the critic's value. A low value means danger: ships near the "
            "area that close in are judged dangerous.",
            "The same tracks coloured by Q_ca itself, darker where it is lower, on one scale for "
            "all encounters of a pilot. Of a pilot that chooses manoeuvres it is the value of the "
            "chosen one, which is low only where no manoeuvre keeps clear.",
        ),
        PaperFigure(
            "10", "Priorities over time", "22",
            "In the fourth encounter, priorities of collision avoidance and of the waypoint "
            "alternate as own ship turns away and comes back.",
            _ONE + " Dotted: 600 s and 750 s.",
        ),
        PaperFigure(
            "11", "Situation and priorities at 600 s and 750 s", "22",
            "At 600 s own ship turns to starboard and avoiding has the higher priority. At 750 s "
            "it turns to port for the waypoint, whose priority is now positive while that of "
            "avoiding falls.",
            _ONE + " Arrows: where each ship will be in six minutes.",
        ),
        PaperFigure(
            "12", "The actor with attention", "23",
            "The sum over ships becomes a mean weighted with attention.",
            "Widths are read from the weight matrices of the preset paper with an attention actor.",
        ),
        PaperFigure(
            "13", "Attention", "23",
            "Attention goes from ship to ship as each becomes the one to avoid. The ship that "
            "overtakes keeps nearly all of it once everything is past, so attention alone is not "
            "intention.",
            _ONE,
        ),
        PaperFigure(
            "14", "Intention", "24",
            "Value times attention shows which ships the decision is about; one that is no danger "
            "drops out although it is attended to.",
            _ONE + " First the increment of Q_ca times attention (the journal's), then Q_ca times "
            "attention (the preprint's).",
        ),
        PaperFigure(
            "15", "Measures of intention over time", "22-24",
            "Priority and intention rise together about 600 s and differ from 200 to 500 s. Which "
            "is right is left to experts.",
            _ONE + " Both readings of Eq. 24, below priorities, danger and attention.",
        ),
    )
}  # fmt: skip
