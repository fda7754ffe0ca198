/** What all components share. */

import { LitElement } from "lit";

import { store } from "../store";

/** A component that is rendered again whenever the store changes. */
export class StoreElement extends LitElement {
  override connectedCallback(): void {
    super.connectedCallback();
    store.subscribe(this);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    store.unsubscribe(this);
  }
}

/** The value of the field that an event comes from. */
export const inputValue = (event: Event): string =>
  (event.target as HTMLInputElement | HTMLSelectElement).value;
