// SPDX-License-Identifier: Apache-2.0
// Requests to the server that sent this page. The token stands in the fragment of the address, which no request carries.

export const token = location.hash.slice(1).split("/")[0];

/** A refusal of the server: its own words. */
export class Refused extends Error {
  /** `refused`: the edit that cannot be made: { list, index } of the request. */
  constructor(text, status, refused) {
    super(text);
    Object.assign(this, { status, refused });
  }
}

/** No server answers, or its answer breaks off. */
export class Gone extends Error {}
/** After that long it is asked again. */
export const GONE_MS = 500;
const gone = (error) => { throw new Gone(error.message); };

async function send(place, body) {
  const answer = await fetch("/" + place, {
    method: "POST",
    headers: { "X-Mtf-Token": token, "Content-Type": "application/json" },
    body: JSON.stringify(body),
  }).catch(gone);
  if (!answer.ok) throw new Refused((await answer.text().catch(gone)).trim(), answer.status);
  return answer;
}

const isJson = (answer) => answer.headers.get("Content-Type") === "application/json";

export async function ask(place, body) {
  const json = await (await send(place, body)).json().catch(gone);
  if (json.error !== undefined) throw new Refused(json.error, json.status, json.refused);
  return json;
}

export async function bytes(place, body, begun) {
  const answer = await send(place, body);
  begun?.();
  if (!isJson(answer)) return answer.arrayBuffer().catch(gone);
  const { error, status, refused } = await answer.json().catch(gone);
  throw new Refused(error, status, refused);
}

/**
 * Facts and 16-bit pixels of one body: four bytes with the length of the JSON, the JSON, the numbers; what follows.
 * `begun` hears when the answer begins: the server is free then.
 */
export async function picture(place, body, begun) {
  const buffer = await bytes(place, body, begun);
  const length = new DataView(buffer).getUint32(0, true);
  const facts = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const end = 4 + length + 2 * facts.width * facts.height;
  return { ...facts, pixels: new Uint16Array(buffer, 4 + length, facts.width * facts.height), more: facts.before ? buffer.slice(end) : null };
}

/** Tells the server, for as long as the page is open, that it is; `lost` and `back` hear of a server that has ended. */
export async function stay(lost, back) {
  for (let gone = false;;) {
    try {
      await ask("here", {});
      if (gone) back();
      gone = false;
    } catch (error) {
      gone = true;
      lost(error);
      await new Promise((resolve) => setTimeout(resolve, 2000));
    }
  }
}
