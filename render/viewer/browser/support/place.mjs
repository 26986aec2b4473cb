// Places of tests: {x, z} in metres, {yaw, pitch, fov, k} in degrees, method.
const MIDDLE = { x: 0, z: 0, yaw: 0, pitch: 0, fov: 75, k: 90, method: "two-sided" };

/** What is not given is as in the middle of the room. */
export function place(parts) {
  return { ...MIDDLE, ...parts };
}

/** What the page's address has after its path. */
export function addressOf(at) {
  return `#${new URLSearchParams(Object.entries(at).map(([key, value]) => [key, String(value)]))}`;
}
