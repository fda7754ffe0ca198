/** Why not another course? What each is worth less than the chosen manoeuvre, and for whom. */

import { css, html, nothing } from "lit";
import { customElement } from "lit/decorators.js";

import { type ComparedCourse, comparedCourses } from "../domain/alternatives";
import { formatCourse } from "../domain/units";
import { store } from "../store";
import { shared } from "../style/shared";
import { shipBadge } from "./ship-badge";
import { StoreElement } from "./store-element";

@customElement("gh-alternatives")
export class Alternatives extends StoreElement {
  static override styles = [
    shared,
    css`
      :host {
        display: block;
        padding: 0 4px;
      }
      table {
        width: 100%;
        border-collapse: collapse;
        font-size: 12.5px;
        margin-top: 6px;
      }
      th,
      td {
        text-align: right;
        font-weight: 500;
        padding: 4px 0 4px 6px;
        white-space: nowrap;
      }
      thead th {
        font-size: 11px;
        color: var(--gh-muted);
      }
      th:first-child,
      th:last-child,
      td:last-child {
        text-align: left;
      }
      th:first-child {
        padding-left: 0;
      }
      .chosen {
        font-weight: 700;
      }
    `,
  ];

  override render() {
    const courses = store.frame ? comparedCourses(store.frame) : [];
    if (!courses.length) return nothing;
    return html`<table class="number">
      <thead>
        <tr>
          <th scope="col">Instead</th>
          <th scope="col">Course</th>
          <th scope="col">Points</th>
          <th scope="col">Because of</th>
        </tr>
      </thead>
      <tbody>
        ${courses.map((course) => row(course))}
      </tbody>
    </table>`;
  }
}

function row(course: ComparedCourse) {
  const chosen = course.loss === 0;
  return html`<tr class=${chosen ? "chosen" : ""}>
    <th scope="row">${course.label}</th>
    <td>${formatCourse(course.courseRad)}</td>
    <td>${chosen ? "chosen" : `−${points(course.loss)}`}</td>
    <td>${because(course)}</td>
  </tr>`;
}

function because({ reason, reasonLoss }: ComparedCourse) {
  if (!reason) return nothing;
  const size = html`<span class="muted">−${points(reasonLoss)}</span>`;
  if ("task" in reason) return html`${reason.task === "helm" ? "altering" : "waypoint"} ${size}`;
  const name = store.target(reason.ship)?.name ?? reason.ship;
  return html`<span title=${name}>${shipBadge(reason.ship)}</span> ${size}`;
}

const points = (value: number): string => value.toFixed(value < 100 ? 1 : 0);
