/** What the page knows, in one place; components read it and ask it, nothing else. */

import type { ReactiveController, ReactiveControllerHost } from "lit";

import { bandForFrame } from "./domain/certified-band";
import { deadReckon } from "./domain/dead-reckoning";
import { ColourRegistry } from "./domain/colours";
import { dataAge } from "./domain/liveness";
import { appendFrame, dropSweeps, MAX_FRAMES } from "./domain/history";
import { liveness, type Liveness } from "./domain/liveness";
import {
  idsByProminence,
  largestDanger,
  rankTargets,
  roundScale,
  type RankedTarget,
} from "./domain/ranking";
import { ReconnectingSocket, socketUrl } from "./socket";
import { Settings } from "./settings";
import type {
  Alarm,
  Answer,
  Banded,
  Bounds,
  Catalogue,
  ClientMessage,
  Frame,
  FrameNow,
  Hello,
  Meeting,
  ServerMessage,
  Session,
  Target,
  WhatIf,
} from "./protocol.gen";

const NOTICE_MS = 8000;
/** An answer to "what if" is of its instant: it goes when it is so old. */
const WHATIF_MS = 60_000;

export interface Notice {
  id: number;
  text: string;
  failure: boolean;
}

export class Store {
  version = "";
  catalogue: Catalogue | null = null;
  limits: Bounds | null = null;
  /** As whom the server greets this page. */
  role: Hello["role"] | null = null;
  session: Session | null = null;
  /** What the server makes ready while the session goes on. */
  preparing: string | null = null;
  frames: Frame[] = [];
  compareFrames: Frame[] = [];
  current: (Partial<FrameNow> & { frame: Frame }) | null = null;
  /** The last predicted track: at high speed not every frame brings one. */
  path: [number, number][] = [];
  /** The answer to the last "what if", until it is dismissed or old. */
  whatIf: Answer | null = null;
  /** Asked, and not answered yet. */
  awaitingWhatIf = false;
  /** The certified band that was told last: of which frame, it says itself. */
  lastBand: Banded | null = null;
  alarms: Alarm[] = [];
  notices: Notice[] = [];
  rows: RankedTarget[] = [];
  dangerScale = 0.5;

  selected: string | null = null;
  hovered: string | null = null;
  readonly settings = new Settings(() => this.requestUpdate());
  readonly colours = new ColourRegistry();

  private readonly socket: ReconnectingSocket;
  private readonly hosts = new Set<ReactiveControllerHost>();
  private frameAt_ms: number | null = null;
  private sessionAt_ms = 0;
  private deadReckoned: Frame | null = null;
  private scheduled = false;
  private noticeCount = 0;
  private whatIfTimer = 0;

  constructor(url = socketUrl(location.href)) {
    this.socket = new ReconnectingSocket(
      url,
      (m) => this.receive(m),
      () => this.connectionChanged(),
    );
  }

  start(): void {
    this.socket.start();
    window.setInterval(() => this.tick(), 1000);
  }

  send(message: ClientMessage): void {
    if (!this.socket.send(message)) this.notify("Not sent: there is no connection", true);
  }

  // What is shown

  /** The present frame; of live traffic as it has moved on since. */
  get frame(): Frame | null {
    return this.deadReckoned ?? this.current?.frame ?? null;
  }

  get liveness(): Liveness {
    return liveness(
      {
        open: this.socket.state === "open",
        since_s: (performance.now() - this.socket.since_ms) / 1000,
      },
      this.session,
      this.frameAge_s,
      this.sessionAge_s,
    );
  }

  /** Seconds since the session was told, with the ages in it. */
  private get sessionAge_s(): number {
    return (performance.now() - this.sessionAt_ms) / 1000;
  }

  /** Seconds since the last frame came in, by this computer's clock. */
  get frameAge_s(): number | null {
    return this.frameAt_ms === null ? null : (performance.now() - this.frameAt_ms) / 1000;
  }

  /** Seconds since what is shown was heard: in live traffic own ship's position, else the frame. */
  get dataAge_s(): number | null {
    return dataAge(this.session, this.frameAge_s, this.sessionAge_s);
  }

  /** Whether this page only looks on: what all see is the owner's to change. */
  get viewOnly(): boolean {
    return this.role === "viewer";
  }

  /** Ids of the ships of note, in the order of their colours. */
  get colouredShips(): string[] {
    return (this.frame?.targets ?? [])
      .filter((t) => this.colours.indexOf(t.id) !== null)
      .sort((a, b) => this.colours.indexOf(a.id)! - this.colours.indexOf(b.id)!)
      .map((t) => t.id);
  }

  target(id: string | null): Target | null {
    return this.frame?.targets.find((t) => t.id === id) ?? null;
  }

  encounter(id: string): Meeting | null {
    return this.current?.encounters?.[id] ?? null;
  }

  /** The ship that a hand or an eye is on. */
  get highlighted(): string | null {
    return this.hovered ?? this.selected;
  }

  /** The certified band of the rudder shown, or why there is none; null while nothing is known. */
  get band(): Banded | null {
    return bandForFrame(this.lastBand, this.current?.frame ?? null);
  }

  // What the viewer does

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

  /** CPA limits are the server's; they are shown as asked for until it says otherwise. */
  setLimits(limits: Bounds): void {
    this.limits = limits;
    this.send({ type: "limits", ...limits });
    this.requestUpdate();
  }

  /** What if she were not there, were not seen, kept her course; or the rudder were put over? */
  askWhatIf(change: WhatIf["change"], more: { ship?: string; degrees?: number }): void {
    this.awaitingWhatIf = true;
    this.send({ type: "whatif", change, ...more });
    this.requestUpdate();
  }

  dismissWhatIf(): void {
    window.clearTimeout(this.whatIfTimer);
    this.whatIf = null;
    this.requestUpdate();
  }

  dismiss(id: number): void {
    this.notices = this.notices.filter((n) => n.id !== id);
    this.requestUpdate();
  }

  notify(text: string, failure: boolean): void {
    const id = ++this.noticeCount;
    this.notices = [...this.notices.slice(-2), { id, text, failure }];
    window.setTimeout(() => this.dismiss(id), NOTICE_MS);
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
        this.preparing = message.what;
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
        this.whatIfTimer = window.setTimeout(() => this.dismissWhatIf(), WHATIF_MS);
        break;
      case "failure":
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

  private newSession(session: Session): void {
    const before = this.session;
    const other = before && (before.source !== session.source || before.mode !== session.mode);
    if (other) this.resetVoyage();
    if (!session.compare) this.compareFrames = [];
    this.session = session;
    this.sessionAt_ms = performance.now();
  }

  private resetVoyage(): void {
    this.dismissWhatIf();
    this.frames = [];
    this.compareFrames = [];
    this.current = this.deadReckoned = null;
    this.lastBand = null;
    this.path = [];
    this.frameAt_ms = null;
    this.alarms = [];
    this.selected = null;
    this.hovered = null;
    this.colours.clear();
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

  private newFrame(instant: FrameNow): void {
    const { frame, compare } = instant;
    const before = this.frames.at(-1);
    if (before) dropSweeps(before);
    this.frames = appendFrame(this.frames, frame);
    if (compare) this.compareFrames = appendFrame(this.compareFrames, compare);
    if (instant.path) this.path = instant.path;
    this.current = instant;
    this.deadReckoned = null;
    this.frameAt_ms = performance.now();
    this.updateRanking();
  }

  private updateRanking(): void {
    const frame = this.frame;
    if (!frame) return;
    this.dangerScale = roundScale(largestDanger(this.frames));
    this.rows = rankTargets(frame, this.alarms, this.dangerScale);
    const ids = idsByProminence(this.rows, (id) => this.colours.indexOf(id) !== null);
    const chosen = this.selected ? [this.selected, ...ids.filter((i) => i !== this.selected)] : ids;
    this.colours.update(chosen, new Set(frame.targets.map((t) => t.id)));
  }

  private connectionChanged(): void {
    this.preparing = null;
    this.awaitingWhatIf = false;
    this.requestUpdate();
  }

  /** Once a second: ages grow, and live traffic goes on until the next frame. */
  private tick(): void {
    const [frame, age_s] = [this.current?.frame, this.frameAge_s];
    if (this.liveness.state === "live" && frame && age_s !== null) {
      this.deadReckoned = deadReckon(frame, age_s);
      this.updateRanking();
    }
    this.requestUpdate();
  }

  // Who listens

  add(host: ReactiveControllerHost): void {
    this.hosts.add(host);
  }

  remove(host: ReactiveControllerHost): void {
    this.hosts.delete(host);
  }

  /** Redraw all once, with the next picture of the screen. */
  requestUpdate(): void {
    if (this.scheduled) return;
    this.scheduled = true;
    queueMicrotask(() => {
      this.scheduled = false;
      for (const host of this.hosts) host.requestUpdate();
    });
  }
}

/** Binds a component to the store: it is drawn anew whenever something changes. */
export class StoreController implements ReactiveController {
  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly store: Store,
  ) {
    host.addController(this);
  }

  hostConnected(): void {
    this.store.add(this.host);
  }

  hostDisconnected(): void {
    this.store.remove(this.host);
  }
}

/** The one store of this page. */
export const store = new Store();
