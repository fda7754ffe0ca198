/** The state of the page in one place: components read it and call it, nothing else. */

import { bandForFrame } from "./domain/certified-band";
import { ColourRegistry } from "./domain/colours";
import { deadReckon } from "./domain/dead-reckoning";
import { appendFrame, dropSweeps, MAX_FRAMES } from "./domain/history";
import { dataAge, liveness, type Liveness } from "./domain/liveness";
import {
  idsByProminence,
  largestDanger,
  type RankedTarget,
  rankTargets,
  roundScale,
} from "./domain/ranking";
import type {
  Alarm,
  AlarmLimits,
  AskWhatIf,
  BandMessage,
  Catalogue,
  EncounterStatus,
  Frame,
  FrameMessage,
  Hello,
  Request,
  ServerMessage,
  SessionMessage,
  Target,
  WhatIfMessage,
} from "./protocol.gen";
import { Settings } from "./settings";
import { ReconnectingSocket, socketUrl } from "./socket";

const NOTICE_MS = 8000;
/** A what-if answer belongs to its instant: it is removed when it is this old. */
const WHAT_IF_MS = 60_000;

export interface PageNotice {
  id: number;
  text: string;
  failure: boolean;
}

/** What is rendered again when the store changes. */
interface Subscriber {
  requestUpdate: () => void;
}

export class Store {
  version = "";
  catalogue: Catalogue | null = null;
  limits: AlarmLimits | null = null;
  /** The role that the server gives this page. */
  role: Hello["role"] | null = null;
  session: SessionMessage | null = null;
  /** What the server prepares while the session goes on. */
  preparing: string | null = null;
  frames: Frame[] = [];
  compareFrames: Frame[] = [];
  /** The last frame with what the server derived from it; after a jump in time the frame alone. */
  current: (Partial<FrameMessage> & { frame: Frame }) | null = null;
  /** The last predicted track: at high speed not every frame brings one. */
  path: [number, number][] = [];
  /** The answer to the last what-if question, until it is dismissed or old. */
  whatIf: WhatIfMessage | null = null;
  awaitingWhatIf = false;
  /** The last certified band, of whichever frame. */
  lastBand: BandMessage | null = null;
  alarms: Alarm[] = [];
  notices: PageNotice[] = [];
  rows: RankedTarget[] = [];
  dangerScale = 0.5;

  selected: string | null = null;
  hovered: string | null = null;
  readonly settings = new Settings(() => this.requestUpdate());
  readonly colours = new ColourRegistry();

  private readonly socket: ReconnectingSocket;
  private readonly subscribers = new Set<Subscriber>();
  private frameAt_ms: number | null = null;
  private sessionAt_ms = 0;
  /** The current frame of live traffic, dead-reckoned to now. */
  private deadReckoned: Frame | null = null;
  private scheduled = false;
  private noticeCount = 0;
  private whatIfTimer = 0;

  constructor(url = socketUrl(location.href)) {
    this.socket = new ReconnectingSocket(
      url,
      (message) => this.receive(message),
      () => this.connectionChanged(),
    );
  }

  start(): void {
    this.socket.start();
    window.setInterval(() => this.tick(), 1000);
  }

  send(message: Request): void {
    if (!this.socket.send(message)) this.notify("Not sent: no connection", true);
  }

  // What is shown

  /** The frame to show; that of live traffic is dead-reckoned to now. */
  get frame(): Frame | null {
    return this.deadReckoned ?? this.current?.frame ?? null;
  }

  get liveness(): Liveness {
    const { state, since_ms } = this.socket;
    return liveness(
      { open: state === "open", since_s: (performance.now() - since_ms) / 1000 },
      this.session,
      this.frameAge_s,
      this.sessionAge_s,
    );
  }

  /** Seconds since the last `session` message, and the ages in it. */
  private get sessionAge_s(): number {
    return (performance.now() - this.sessionAt_ms) / 1000;
  }

  /** Seconds since the last frame arrived. */
  private get frameAge_s(): number | null {
    return this.frameAt_ms === null ? null : (performance.now() - this.frameAt_ms) / 1000;
  }

  get dataAge_s(): number | null {
    return dataAge(this.session, this.frameAge_s, this.sessionAge_s);
  }

  /** Whether this page may only look: changes that others see are the owner's. */
  get viewOnly(): boolean {
    return this.role === "viewer";
  }

  get hasOpenAlarm(): boolean {
    return this.alarms.some((alarm) => alarm.state === "unacknowledged");
  }

  /** Ids of the ships that have a colour, in the order of the colours. */
  get colouredShips(): string[] {
    return (this.frame?.targets ?? [])
      .flatMap(({ id }) => {
        const index = this.colours.indexOf(id);
        return index === null ? [] : [{ id, index }];
      })
      .sort((a, b) => a.index - b.index)
      .map(({ id }) => id);
  }

  target(id: string | null): Target | null {
    return this.frame?.targets.find((t) => t.id === id) ?? null;
  }

  encounter(id: string): EncounterStatus | null {
    return this.current?.encounters?.[id] ?? null;
  }

  /** The ship that is pointed at, else the selected one. */
  get highlighted(): string | null {
    return this.hovered ?? this.selected;
  }

  /** The certified band of the frame shown, or why it has none; `null` while that is unknown. */
  get band(): BandMessage | null {
    return bandForFrame(this.lastBand, this.current?.frame ?? null);
  }

  // What the user does

  /** Select a ship, or deselect it if it is selected. */
  select(id: string | null): void {
    this.selected = id === this.selected ? null : id;
    this.updateRanking();
    this.requestUpdate();
  }

  hover(id: string | null): void {
    if (id === this.hovered) return;
    this.hovered = id;
    this.requestUpdate();
  }

  /** Set the CPA limits; they are shown at once, until the server says otherwise. */
  setLimits(limits: AlarmLimits): void {
    this.limits = limits;
    this.send({ type: "limits", ...limits });
    this.requestUpdate();
  }

  askWhatIf(change: AskWhatIf["change"], details: { ship?: string; rudder_deg?: number }): void {
    this.awaitingWhatIf = true;
    this.send({ type: "whatif", change, ...details });
    this.requestUpdate();
  }

  dismissWhatIf(): void {
    window.clearTimeout(this.whatIfTimer);
    this.whatIf = null;
    this.requestUpdate();
  }

  dismissNotice(id: number): void {
    this.notices = this.notices.filter((notice) => notice.id !== id);
    this.requestUpdate();
  }

  private notify(text: string, failure: boolean): void {
    const id = ++this.noticeCount;
    this.notices = [...this.notices.slice(-2), { id, text, failure }];
    window.setTimeout(() => this.dismissNotice(id), NOTICE_MS);
    this.requestUpdate();
  }

  // What the server says

  receive(message: ServerMessage): void {
    switch (message.type) {
      case "hello":
        this.version = message.version;
        this.catalogue = message.catalogue;
        this.limits = message.limits;
        this.role = message.role;
        break;
      case "preparing":
        this.preparing = message.task;
        break;
      case "session":
        this.newSession(message);
        break;
      case "history":
        this.newHistory(message.frames, message.compare);
        break;
      case "frame":
        this.newFrame(message);
        break;
      case "alarms":
        this.alarms = message.alarms;
        this.updateRanking();
        break;
      case "band":
        this.lastBand = message;
        break;
      case "whatif":
        this.awaitingWhatIf = false;
        this.whatIf = message;
        window.clearTimeout(this.whatIfTimer);
        this.whatIfTimer = window.setTimeout(() => this.dismissWhatIf(), WHAT_IF_MS);
        break;
      case "error":
        this.awaitingWhatIf = false;
        this.notify(message.message, true);
        break;
      case "notice":
        this.notify(message.message, false);
        break;
      case "pong":
        return;
    }
    this.requestUpdate();
  }

  private newSession(session: SessionMessage): void {
    const before = this.session;
    if (before && (before.source !== session.source || before.mode !== session.mode)) this.reset();
    if (!session.compare) this.compareFrames = [];
    this.session = session;
    this.sessionAt_ms = performance.now();
  }

  /** Forget the voyage shown so far. */
  private reset(): void {
    this.newHistory([], []);
    this.alarms = [];
    this.selected = null;
    this.hovered = null;
    this.rows = [];
  }

  private newHistory(frames: Frame[], compare: Frame[]): void {
    this.dismissWhatIf();
    const last = frames.at(-1);
    this.frames = frames.slice(-MAX_FRAMES);
    this.frames.slice(0, -1).forEach(dropSweeps);
    this.compareFrames = compare.slice(-MAX_FRAMES);
    this.compareFrames.forEach(dropSweeps);
    this.path = [];
    this.lastBand = null;
    this.current = last ? { frame: last } : null;
    this.deadReckoned = null;
    this.frameAt_ms = last ? performance.now() : null;
    this.colours.clear();
    this.updateRanking();
  }

  private newFrame(message: FrameMessage): void {
    const before = this.frames.at(-1);
    if (before) dropSweeps(before);
    this.frames = appendFrame(this.frames, message.frame);
    if (message.compare) this.compareFrames = appendFrame(this.compareFrames, message.compare);
    if (message.predicted_track) this.path = message.predicted_track;
    this.current = message;
    this.deadReckoned = null;
    this.frameAt_ms = performance.now();
    this.updateRanking();
  }

  private updateRanking(): void {
    const { frame } = this;
    if (!frame) return;
    this.dangerScale = roundScale(largestDanger(this.frames));
    this.rows = rankTargets(frame, this.alarms, this.dangerScale);
    const ids = idsByProminence(this.rows, (id) => this.colours.indexOf(id) !== null);
    const wanted = this.selected ? [this.selected, ...ids.filter((i) => i !== this.selected)] : ids;
    this.colours.update(wanted, new Set(ids));
  }

  private connectionChanged(): void {
    this.preparing = null;
    this.awaitingWhatIf = false;
    this.requestUpdate();
  }

  /** Once a second: ages grow, and live traffic is dead-reckoned until the next frame. */
  private tick(): void {
    const [frame, age_s] = [this.current?.frame, this.frameAge_s];
    if (this.liveness.state === "live" && frame && age_s !== null) {
      this.deadReckoned = deadReckon(frame, age_s);
      this.updateRanking();
    }
    this.requestUpdate();
  }

  // Who is told of changes

  subscribe(subscriber: Subscriber): void {
    this.subscribers.add(subscriber);
  }

  unsubscribe(subscriber: Subscriber): void {
    this.subscribers.delete(subscriber);
  }

  /** Render all subscribers again, once for all changes of the present task. */
  private requestUpdate(): void {
    if (this.scheduled) return;
    this.scheduled = true;
    queueMicrotask(() => {
      this.scheduled = false;
      for (const subscriber of this.subscribers) subscriber.requestUpdate();
    });
  }
}

/** The store of this page. */
export const store = new Store();
