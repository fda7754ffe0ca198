/** Plain frames and messages; each test states only what differs. */

import type { Alarm, Frame, FrameMessage, SessionMessage, Target } from "../src/protocol.gen";

export const target = (id: string, some: Partial<Target> = {}): Target => ({
  id,
  name: `ship ${id}`,
  east_m: 0,
  north_m: 5000,
  course_rad: Math.PI,
  speed_m_s: 5,
  range_m: 5000,
  bearing_rad: 0,
  dcpa_m: 500,
  tcpa_s: 500,
  danger: 0,
  ...some,
});

export const frame = (
  time_s: number,
  targets: Target[] = [],
  some: Partial<Frame> = {},
): Frame => ({
  time_s,
  pilot: "paper-attention",
  source: "imazu:1",
  ship: {
    loa_m: 340,
    beam_m: 60,
    K_1_s: 0.1827,
    T_s: 11.1,
    rudder_limit_rad: 0.0873,
    speed_m_s: 5.144,
  },
  own: { east_m: 0, north_m: 0, heading_rad: 0, speed_m_s: 5.144, rate_of_turn_rad_s: 0 },
  waypoint: { east_m: 0, north_m: 46300 },
  targets,
  ...some,
});

export const alarm = (target: string, some: Partial<Alarm> = {}): Alarm => ({
  id: `cpa-${target}`,
  target,
  name: `ship ${target}`,
  dcpa_m: 100,
  tcpa_s: 300,
  since_s: 0,
  state: "unacknowledged",
  cause: "CPA",
  ...some,
});

/** A frame as the server sends it, without anything derived from it. */
export const frameMessage = (shown: Frame): FrameMessage => ({
  type: "frame",
  frame: shown,
  encounters: {},
  sent_utc: "2026-01-01T00:00:00.000Z",
  sentence: null,
});

export const session = (some: Partial<SessionMessage> = {}): SessionMessage => ({
  type: "session",
  source: "imazu:1",
  title: "Imazu 1",
  mode: "simulated",
  pilot: "paper-attention",
  compare: null,
  ship: "paper",
  playing: true,
  rate: 1,
  time_s: 0,
  end_s: 3600,
  seekable_from_s: 0,
  seekable_to_s: 3600,
  notes: [],
  connected: true,
  last_report_age_s: null,
  own_position_age_s: null,
  log: null,
  ...some,
});
