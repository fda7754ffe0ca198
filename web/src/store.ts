/** What the page knows, in one place; components read it and ask it, nothing else. */

import type { ReactiveController, ReactiveControllerHost } from "lit";

import { bandOf } from "./domain/certified-band";
import { carriedOn } from "./domain/dead-reckoning";
import { Book } from "./domain/colours";
import { heardAge } from "./domain/data-age";
import { added, lighten, MOST_FRAMES } from "./domain/history";
import { liveness, type Liveness } from "./domain/liveness";
import { byNote, largestDanger, ranked, roundScale, type Ranked } from "./domain/ranking";
import { Link, socketUrl } from "./socket";
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
  now: (Partial<FrameNow> & { frame: Frame }) | null = null;
  /** The last predicted track: at high speed not every frame brings one. */
  path: [number, number][] = [];
  /** The answer to the last "what if", until it is dismissed or old. */
  whatIf: Answer | null = null;
  /** Asked, and not answered yet. */
  asking = false;
  /** The certified band that was told last: of which frame, it says itself. */
  banded: Banded | null = null;
  alarms: Alarm[] = [];
  notices: Notice[] = [];
  rows: Ranked[] = [];
  dangerScale = 0.5;

  selected: string | null = null;
  hovered: string | null = null;
  readonly settings = new Settings(() => this.changed());
  readonly book = new Book();

  private readonly link: Link;
  private readonly hosts = new Set<ReactiveControllerHost>();
  private frameAt_ms: number | null = null;
  private sessionAt_ms = 0;
  private shown: Frame | null = null;
  private scheduled = false;
  private noticeCount = 0;
  private whatIfTimer = 0;

  constructor(url = socketUrl(location.href)) {
    this.link = new Link(
      url,
      (m) => this.take(m),
      () => this.linked(),
    );
  }

  start(): void {
    this.link.start();
    window.setInterval(() => this.tick(), 1000);
  }

  send(message: ClientMessage): void {
    if (!this.link.send(message)) this.note("Not sent: there is no connection", true);
  }

  // What is shown

  /** The present frame; of live traffic as it has moved on since. */
  get frame(): Frame | null {
    return this.shown ?? this.now?.frame ?? null;
  }

  get liveness(): Liveness {
    return liveness(
      {
        open: this.link.state === "open",
        since_s: (performance.now() - this.link.since_ms) / 1000,
      },
      this.session,
      this.frameAge_s,
      this.saidAge_s,
    );
  }

  /** Seconds since the session was told, with the ages in it. */
  private get saidAge_s(): number {
    return (performance.now() - this.sessionAt_ms) / 1000;
  }

  /** Seconds since the last frame came in, by this computer's clock. */
  get frameAge_s(): number | null {
    return this.frameAt_ms === null ? null : (performance.now() - this.frameAt_ms) / 1000;
  }

  /** Seconds since what is shown was heard: in live traffic own ship's position, else the frame. */
  get heardAge_s(): number | null {
    return heardAge(this.session, this.frameAge_s, this.saidAge_s);
  }

  /** Whether this page only looks on: what all see is the owner's to change. */
  get viewOnly(): boolean {
    return this.role === "viewer";
  }

  /** Ids of the ships of note, in the order of their colours. */
  get noted(): string[] {
    return (this.frame?.targets ?? [])
      .filter((t) => this.book.place(t.id) !== null)
      .sort((a, b) => this.book.place(a.id)! - this.book.place(b.id)!)
      .map((t) => t.id);
  }

  target(id: string | null): Target | null {
    return this.frame?.targets.find((t) => t.id === id) ?? null;
  }

  encounter(id: string): Meeting | null {
    return this.now?.encounters?.[id] ?? null;
  }

  /** The ship that a hand or an eye is on. */
  get lit(): string | null {
    return this.hovered ?? this.selected;
  }

  /** The certified band of the rudder shown, or why there is none; null while nothing is known. */
  get band(): Banded | null {
    return bandOf(this.banded, this.now?.frame ?? null);
  }

  // What the viewer does

  select(id: string | null): void {
    this.selected = id === this.selected ? null : id;
    this.rank();
    this.changed();
  }

  hover(id: string | null): void {
    if (id === this.hovered) return;
    this.hovered = id;
    this.changed();
  }

  /** CPA limits are the server's; they are shown as asked for until it says otherwise. */
  setLimits(limits: Bounds): void {
    this.limits = limits;
    this.send({ type: "limits", ...limits });
    this.changed();
  }

  /** What if she were not there, were not seen, kept her course; or the rudder were put over? */
  ask(change: WhatIf["change"], more: { ship?: string; degrees?: number }): void {
    this.asking = true;
    this.send({ type: "whatif", change, ...more });
    this.changed();
  }

  dismissWhatIf(): void {
    window.clearTimeout(this.whatIfTimer);
    this.whatIf = null;
    this.changed();
  }

  dismiss(id: number): void {
    this.notices = this.notices.filter((n) => n.id !== id);
    this.changed();
  }

  note(text: string, failure: boolean): void {
    const id = ++this.noticeCount;
    this.notices = [...this.notices.slice(-2), { id, text, failure }];
    window.setTimeout(() => this.dismiss(id), NOTICE_MS);
    this.changed();
  }

  // What the server says

  take(message: ServerMessage): void {
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
        this.rank();
        break;
      case "band":
        this.banded = message;
        break;
      case "whatif":
        this.asking = false;
        this.whatIf = message;
        window.clearTimeout(this.whatIfTimer);
        this.whatIfTimer = window.setTimeout(() => this.dismissWhatIf(), WHATIF_MS);
        break;
      case "failure":
        this.asking = false;
        this.note(message.message, true);
        break;
      case "notice":
        this.note(message.message, false);
        break;
      case "pong":
        return;
    }
    this.changed();
  }

  private newSession(session: Session): void {
    const before = this.session;
    const other = before && (before.source !== session.source || before.mode !== session.mode);
    if (other) this.forget();
    if (!session.compare) this.compareFrames = [];
    this.session = session;
    this.sessionAt_ms = performance.now();
  }

  private forget(): void {
    this.dismissWhatIf();
    this.frames = [];
    this.compareFrames = [];
    this.now = this.shown = null;
    this.banded = null;
    this.path = [];
    this.frameAt_ms = null;
    this.alarms = [];
    this.selected = null;
    this.hovered = null;
    this.book.clear();
    this.rows = [];
  }

  private newHistory(frames: Frame[], compare: Frame[]): void {
    this.dismissWhatIf();
    const last = frames.at(-1);
    this.frames = frames.slice(-MOST_FRAMES);
    this.frames.slice(0, -1).forEach(lighten);
    this.compareFrames = compare.slice(-MOST_FRAMES);
    this.compareFrames.forEach(lighten);
    this.path = [];
    this.banded = null;
    this.now = last ? { frame: last } : null;
    this.shown = null;
    this.frameAt_ms = last ? performance.now() : null;
    this.book.clear();
    this.rank();
  }

  private newFrame(instant: FrameNow): void {
    const { frame, compare } = instant;
    const before = this.frames.at(-1);
    if (before) lighten(before);
    this.frames = added(this.frames, frame);
    if (compare) this.compareFrames = added(this.compareFrames, compare);
    if (instant.path) this.path = instant.path;
    this.now = instant;
    this.shown = null;
    this.frameAt_ms = performance.now();
    this.rank();
  }

  private rank(): void {
    const frame = this.frame;
    if (!frame) return;
    this.dangerScale = roundScale(largestDanger(this.frames));
    this.rows = ranked(frame, this.alarms, this.dangerScale);
    const ids = byNote(this.rows, (id) => this.book.place(id) !== null);
    const chosen = this.selected ? [this.selected, ...ids.filter((i) => i !== this.selected)] : ids;
    this.book.update(chosen, new Set(frame.targets.map((t) => t.id)));
  }

  private linked(): void {
    this.preparing = null;
    this.asking = false;
    this.changed();
  }

  /** Once a second: ages grow, and live traffic goes on until the next frame. */
  private tick(): void {
    const [frame, age_s] = [this.now?.frame, this.frameAge_s];
    if (this.liveness.state === "live" && frame && age_s !== null) {
      this.shown = carriedOn(frame, age_s);
      this.rank();
    }
    this.changed();
  }

  // Who listens

  add(host: ReactiveControllerHost): void {
    this.hosts.add(host);
  }

  remove(host: ReactiveControllerHost): void {
    this.hosts.delete(host);
  }

  /** Redraw all once, with the next picture of the screen. */
  changed(): void {
    if (this.scheduled) return;
    this.scheduled = true;
    queueMicrotask(() => {
      this.scheduled = false;
      for (const host of this.hosts) host.requestUpdate();
    });
  }
}

/** Binds a component to the store: it is drawn anew whenever something changes. */
export class Watch implements ReactiveController {
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
