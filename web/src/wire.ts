/**
 * What travels between server and page. `Frame` is docs/frame.schema.json to the letter:
 * SI units, radians clockwise from north; what a pilot or a source lacks is absent.
 */

export interface Ship {
  loa_m: number;
  beam_m: number;
  K_1_s: number;
  T_s: number;
  rudder_limit_rad: number;
  speed_m_s: number;
  rudder_rate_rad_s?: number | null;
}

export interface Own {
  east_m: number;
  north_m: number;
  heading_rad: number;
  speed_m_s: number;
  rate_of_turn_rad_s: number;
  rudder_rad?: number | null;
  latitude_deg?: number | null;
  longitude_deg?: number | null;
}

export interface Place {
  east_m: number;
  north_m: number;
}

export interface Target {
  id: string;
  name: string;
  east_m: number;
  north_m: number;
  course_rad: number;
  speed_m_s: number;
  range_m: number;
  /** Relative to own heading, starboard positive. */
  bearing_rad: number;
  dcpa_m: number;
  tcpa_s: number;
  /** Eq. 13, clipped: 0 outside the domain. */
  danger: number;
  /** Q_ca of the decided rudder: lower is more dangerous. */
  q?: number | null;
  /** The same head's value of a ship far off and opening: the zero of danger. */
  q_far?: number | null;
  q_sweep?: number[] | null;
  priority?: number | null;
  attention?: number | null;
  intention?: number | null;
  intention_level?: number | null;
  /** Her share of the rudder (Shapley value), starboard positive; with the error where it was sampled. */
  shapley_rad?: number | null;
  shapley_error_rad?: number | null;
  /** The rudder less what it would be without her. */
  left_out_rad?: number | null;
  /** Her share of Q of the decision. */
  shapley_value?: number | null;
  /** How far she moves the rudder together with each target of the frame, beyond each alone. */
  shapley_pairs_rad?: number[] | null;
  length_m?: number | null;
  fed?: boolean;
  lost?: boolean;
  age_s?: number | null;
  latitude_deg?: number | null;
  longitude_deg?: number | null;
}

export interface Decision {
  rudder_rad: number;
  /** False: the pilot only advises. Absent: true. */
  applied?: boolean;
  /** What it would be with no other ship: with every `shapley_rad` it adds up to the rudder. */
  alone_rad?: number | null;
  /** What the pilot himself decided, where his guard or an order has the helm. */
  overruled_rad?: number | null;
}

/** What a guard sees on the pilot's own way: who comes first into the domain or to its edge, and when. */
export interface Guard {
  steers: boolean;
  target?: string | null;
  within_s?: number | null;
  /** Eq. 13, unclipped: above 0 inside. */
  depth?: number | null;
}

export interface ByTask {
  waypoint: number;
  collision: number;
  total?: number | null;
}

export interface Sweep {
  rudder_rad: number[];
  waypoint: number[];
  collision: number[];
}

/** Between its ends the pilot's rudder stays while no sensor errs by more than so much. */
export interface Band {
  low_rad: number;
  high_rad: number;
  position_m: number;
  course_rad: number;
  speed_m_s: number;
  /** The side that is certain, if one is. */
  turn?: "starboard" | "port" | null;
}

export interface Frame {
  time_s: number;
  pilot: string;
  source: string;
  ship: Ship;
  own: Own;
  waypoint: Place;
  targets: Target[];
  decision?: Decision | null;
  weights_sha256?: string | null;
  time_utc?: string | null;
  reward?: ByTask | null;
  value?: ByTask | null;
  priority?: ByTask | null;
  sweep?: Sweep | null;
  outside?: string[] | null;
  band?: Band | null;
  guard?: Guard | null;
}

/** An owner may change what all see; a viewer looks on, and may ask what-if. */
export type Role = "owner" | "viewer";
export type SourceKind = "simulated" | "recorded" | "live";
export type Mode = SourceKind | "replay";

export interface SourceEntry {
  source: string;
  title: string;
  kind: SourceKind;
}

export interface PilotEntry {
  name: string;
  title: string;
  kind: "learned" | "classical" | "planner";
  ship: string | null;
}

export interface LogEntry {
  name: string;
  /** Absent of a long one that has not been counted to its end yet. */
  frames?: number;
  time_utc?: string | null;
}

export interface Limits {
  dcpa_m: number;
  tcpa_s: number;
}

export interface Catalogue {
  scenarios: SourceEntry[];
  pilots: PilotEntry[];
  logs: LogEntry[];
}

export interface Session {
  source: string;
  title: string;
  mode: Mode;
  pilot: string;
  compare: string | null;
  ship: string;
  playing: boolean;
  rate: number;
  time_s: number;
  end_s: number | null;
  seekable_from_s: number;
  seekable_to_s: number;
  notes: string[];
  connected?: boolean;
  /** Ages of the last position heard, of any ship and of own ship's own (live). */
  heard_s?: number | null;
  own_s?: number | null;
  /** The file that this session is written to. */
  log?: string | null;
}

export interface Sentence {
  what: string;
  why: string;
  next: string;
}

export type EncounterType = "head-on" | "crossing" | "overtaking" | "overtaken" | "none";

export interface Encounter {
  type: EncounterType;
  role: "give-way" | "stand-on" | "none";
  rule: string | null;
}

export interface Alarm {
  id: string;
  target: string;
  name: string;
  dcpa_m: number;
  tcpa_s: number;
  since_s: number;
  state: "unacknowledged" | "acknowledged";
  cause: string;
}

/** One instant as the server sends it: the frame and what was derived from it. */
export interface Instant {
  frame: Frame;
  compare?: Frame | null;
  path?: [number, number][] | null;
  sentence?: Sentence | null;
  encounters?: Record<string, Encounter> | null;
  sent_utc?: string;
}

export type Change = "deleted" | "blind" | "kept" | "rudder";

/** Own ship's two futures from the frame of `time_s` on, a point every 30 s. */
export interface WhatIf {
  time_s: number;
  change: Change;
  ship: string | null;
  condition: string;
  sentence: string;
  /** As things are. */
  fact: [number, number][];
  /** Under the condition. */
  other: [number, number][];
}

/** The certified rudder band of one frame: of that time, pilot and rudder, and of no other. */
export interface Banded {
  time_s: number;
  pilot: string;
  rudder_rad: number | null;
  band: Band | null;
  /** What is certain; empty without a band. */
  short: string;
  /** Between which rudders and for which errors; or why there is no band. */
  full: string;
}

export type FromServer =
  | { type: "hello"; version: string; catalogue: Catalogue; limits: Limits; role: Role }
  | { type: "preparing"; what: string | null }
  | ({ type: "session" } & Session)
  | { type: "history"; frames: Frame[]; compare?: Frame[] }
  | ({ type: "frame" } & Instant)
  | { type: "alarms"; alarms: Alarm[] }
  | ({ type: "whatif" } & WhatIf)
  | ({ type: "band" } & Banded)
  | { type: "failure"; message: string }
  | { type: "notice"; message: string }
  | { type: "pong" };

export type ToServer =
  | { type: "open"; source: string; pilot?: string; ship?: string; own?: string; at?: string }
  | { type: "replay"; log: string }
  | { type: "pilot"; name: string }
  | { type: "compare"; name: string | null }
  | { type: "play" }
  | { type: "pause" }
  | { type: "rate"; rate: number }
  | { type: "seek"; time_s: number }
  | { type: "acknowledge"; id: string }
  | ({ type: "limits" } & Limits)
  | { type: "whatif"; change: Change; ship?: string; degrees?: number }
  | { type: "ping" };
