/** Ships' names within a sentence. */

/** The words cut where a name begins or ends; a name is taken only as a whole word. */
export function splitAtNames(words: string, names: readonly string[]): string[] {
  if (!names.length) return [words];
  const longest = [...names].sort((a, b) => b.length - a.length).map(escaped);
  const name = new RegExp(`(?<![\\p{L}\\d])(${longest.join("|")})(?![\\p{L}\\d])`, "gu");
  return words.split(name).filter((part) => part !== "");
}

const escaped = (text: string): string => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
