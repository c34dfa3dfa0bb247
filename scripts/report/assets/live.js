import { fromBase64, unpack } from "./unpack.js";

/** Takes in what the run's server sends, from its beginning on, until the run is over. */
export function listen(app, began) {
  const status = document.getElementById("status");
  const source = new EventSource("events");
  const content = (event) => unpack(fromBase64(event.data).buffer);
  source.addEventListener("begin", (event) => {
    status.textContent = "live";
    began(content(event));
  });
  source.addEventListener("ticks", (event) => app().take(content(event)));
  source.addEventListener("map", (event) => app().takeMap(content(event)));
  source.addEventListener("end", () => {
    source.close();
    status.textContent = "the run is over";
    app().ended();
  });
  source.addEventListener("error", () => {
    if (source.readyState !== EventSource.CLOSED) source.close();
    status.textContent = "the run has gone: it ended, or was ended";
    app()?.ended();
  });
}
