/** Which way own ship goes, and what that is called. */

import type { Frame } from "../protocol.gen";

/**
 * Where the pilot steers there is no current, and her heading is her course over ground. Recorded
 * and live own ships are known by their course over ground, which a frame has as `own.heading_rad`.
 */
export const isHeadingKnown = (frame: Frame): boolean => frame.decision?.applied !== false;
