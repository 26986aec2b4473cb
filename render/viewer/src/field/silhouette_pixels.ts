// The pixels of a distance map next to a silhouette: a few of a hundred, found once when it arrives.

/**
 * Pixels, counted through the rows, one of whose eight neighbours is on another surface: inverse
 * distances (in steps, [row][column]) differ by more than `tolerance` of the larger one.
 */
export function silhouettePixels(
  omega: Uint16Array,
  width_px: number,
  tolerance: number,
): Float32Array<ArrayBuffer> {
  const height = omega.length / width_px;
  const found: number[] = [];
  const differ = (a: number, b: number) => Math.abs(a - b) > tolerance * Math.max(a, b);
  for (let row = 0; row < height; ++row) {
    const above = Math.max(row - 1, 0) * width_px;
    const here = row * width_px;
    const below = Math.min(row + 1, height - 1) * width_px;
    for (let column = 0; column < width_px; ++column) {
      const left = (column + width_px - 1) % width_px;
      const right = (column + 1) % width_px;
      const own = omega[here + column]!;
      const isRim =
        differ(own, omega[here + left]!) ||
        differ(own, omega[here + right]!) ||
        differ(own, omega[above + column]!) ||
        differ(own, omega[below + column]!) ||
        differ(own, omega[above + left]!) ||
        differ(own, omega[above + right]!) ||
        differ(own, omega[below + left]!) ||
        differ(own, omega[below + right]!);
      if (isRim) found.push(here + column);
    }
  }
  return Float32Array.from(found);
}
