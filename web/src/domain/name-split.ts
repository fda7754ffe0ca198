/** Ships' names within a sentence. */

/** The text cut before and after each name; a name counts only as a whole word. */
export function splitAtNames(text: string, names: readonly string[]): string[] {
  if (!names.length) return [text];
  const longestFirst = [...names].sort((a, b) => b.length - a.length).map(escapeRegExp);
  const name = new RegExp(`(?<![\\p{L}\\d])(${longestFirst.join("|")})(?![\\p{L}\\d])`, "gu");
  return text.split(name).filter((part) => part !== "");
}

const escapeRegExp = (text: string): string => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
