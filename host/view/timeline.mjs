// The timeline of a recorded session: which tick is shown, how fast it goes, and whether it comes to the recorded states.
import { $, grouped } from "./panel.mjs";

export class Timeline {
  constructor(source, { first, last }) {
    this.last = last;
    $("timeline").hidden = false;
    Object.assign($("scrub"), { min: first, max: last, value: first });
    $("scrub").oninput = () => source.seek(Number($("scrub").value));
    $("speed").onchange = () => source.speed(Number($("speed").value));
  }

  show({ tick, session }) {
    if (!session.isSeeking) $("scrub").value = tick;
    $("at").textContent = `${grouped(tick)} of ${grouped(this.last)}`;
    const { compared, differs } = session;
    $("compared").textContent = differs ? `other from tick ${grouped(differs.tick)} on` : `${grouped(compared)} compared, the same`;
    $("compared").className = differs ? "bad" : "";
    $("compared").title = differs ? `recorded ${differs.recorded}, here ${differs.here}` : "State hashes of the session, against those of this page's kernel";
  }
}
